//! Decoder-side smoothing: ranges that coarse steps have torn into stairs are evened out, each within its own cell.

use std::vec::Vec;

use crate::image::Level;

/// Pixels on either side that count.
const REACH: usize = 4;

/// Moves each return of a row towards the mean of those around it, by at most `cell` levels.
///
/// As many pixels on the left as on the right are taken, so that an even slope stays what it is, up to the first that is
/// empty or more than three cells off (an edge: nothing is drawn across it). What is moved is never farther from the
/// level that was sent than the sent level may be from the measured one.
pub(crate) fn smooth_row<L: Level>(levels: &[L], cell: f32, smoothed: &mut Vec<f32>) {
    smoothed.clear();
    smoothed.extend((0..levels.len()).map(|at| smooth_one(levels, at, cell)));
}

fn smooth_one<L: Level>(levels: &[L], at: usize, cell: f32) -> f32 {
    let level = |at: usize| levels.get(at).map_or(0.0, |level| f32::from(level.get()));
    let here = level(at);
    let is_near = |there: f32| there > 0.0 && (there - here).abs() <= 3.0 * cell;
    let (mut sum, mut count) = (here, 1.0);
    for off in 1..=REACH.min(at) {
        let (left, right) = (level(at - off), level(at + off));
        if !is_near(left) || !is_near(right) {
            break;
        }
        (sum, count) = (sum + left + right, count + 2.0);
    }
    here + (sum / count - here).clamp(-cell, cell)
}

#[cfg(test)]
mod tests {
    use super::smooth_row;
    use std::vec::Vec;

    fn smoothed(levels: &[u8], cell: f32) -> Vec<f32> {
        let mut smoothed = Vec::new();
        smooth_row(levels, cell, &mut smoothed);
        smoothed
    }

    #[test]
    fn slopes_and_what_stands_alone_stay() {
        assert_eq!(smoothed(&[3, 4, 5, 6, 7], 0.5), [3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(smoothed(&[0, 9, 0, 200], 0.5), [0.0, 9.0, 0.0, 200.0]);
        assert_eq!(smoothed(&[], 0.5), [0.0; 0]);
    }

    #[test]
    fn stairs_become_flatter_and_edges_do_not() {
        let stairs = smoothed(&[9, 9, 9, 10, 10, 10, 90, 90, 91], 0.5);
        assert!(9.0 < stairs[2] && stairs[2] < stairs[3] && stairs[3] < 10.0, "{stairs:?}");
        assert_eq!((stairs[5], stairs[6]), (10.0, 90.0));
    }

    #[test]
    fn nothing_leaves_its_cell() {
        for cell in [0.5, 3.5] {
            let levels = [20_u8, 21, 22, 20, 23, 21, 20, 25, 30, 29, 22, 20];
            let moved = smoothed(&levels, cell);
            assert!(moved.iter().zip(levels).all(|(moved, level)| (moved - f32::from(level)).abs() <= cell));
        }
    }
}
