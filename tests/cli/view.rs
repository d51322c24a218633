//! The picture is a PNG that shows something.

use std::collections::BTreeSet;

use super::run::Place;

struct Picture {
    width: usize,
    rgb: Vec<[u8; 3]>,
}

impl Picture {
    fn of(png: &[u8]) -> Self {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        Self { width: info.width as usize, rgb: pixels.as_chunks().0.to_vec() }
    }

    /// Share of the pixels of a column range and row range that have a color, rather than being black or gray.
    fn colored(&self, x: std::ops::Range<usize>, y: std::ops::Range<usize>) -> f64 {
        let all = y.flat_map(|y| x.clone().map(move |x| (x, y))).map(|(x, y)| self.rgb[y * self.width + x]);
        let colors: Vec<bool> = all.map(|[r, g, b]| r.abs_diff(g).max(g.abs_diff(b)) > 20).collect();
        colors.iter().filter(|&&color| color).count() as f64 / colors.len() as f64
    }

    fn height(&self) -> usize {
        self.rgb.len() / self.width
    }
}

#[test]
fn a_scan_is_shown_with_its_frame() {
    let place = Place::with_scan();
    place.fine(&["view", "scan.bin", "-o", "scan.png"]);
    let picture = Picture::of(&place.read("scan.png"));
    assert!(picture.width >= 1000 && picture.height() >= 800);
    let (middle, bottom) = (picture.width / 2, picture.height());
    assert!(picture.colored(20..picture.width - 20, 60..280) > 0.6, "range image");
    assert!(picture.colored(20..middle - 20, 400..bottom) > 0.02, "original from above");
    assert!(picture.colored(middle + 20..picture.width, 400..bottom) > 0.02, "decoded from above");
    let colors: BTreeSet<[u8; 3]> = picture.rgb.iter().copied().collect();
    assert!(colors.len() > 100);
}

#[test]
fn a_frame_is_shown_by_its_number() {
    let place = Place::new();
    place.fine(&["simulate", "-o", "t.bin", "--turns", "2"]);
    place.fine(&["encode", "t-000000.bin", "t-000001.bin", "-o", "t.flicr", "--columns", "512", "--bits", "12"]);
    place.fine(&["view", "t.flicr", "-o", "0.png"]);
    place.fine(&["view", "t.flicr", "-o", "1.png", "--frame", "1"]);
    assert_ne!(place.read("0.png"), place.read("1.png"));
    let picture = Picture::of(&place.read("1.png"));
    assert!(picture.colored(20..picture.width - 20, 60..280) > 0.6, "range image");
}

#[test]
fn columns_change_the_picture() {
    let place = Place::with_scan();
    place.fine(&["view", "scan.bin", "-o", "many.png"]);
    place.fine(&["view", "scan.bin", "-o", "few.png", "--columns", "64"]);
    let [many, few] = ["many.png", "few.png"].map(|name| Picture::of(&place.read(name)));
    let right = |picture: &Picture| picture.colored(picture.width / 2 + 20..picture.width, 400..picture.height());
    assert!(right(&few) < 0.2 * right(&many), "64 columns keep few points");
}
