//! A picture of what is received, on the terminal, as it comes: red is near, blue is far.

use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write as _};
use std::time::{Duration, Instant};

use console::Term;
use flicr::stream::ReceivedStrip;

use crate::failure::Failure;
use crate::view::color;

/// Time from picture to picture.
const INTERVAL: Duration = Duration::from_millis(100);
/// Lines below the picture.
const LINES: usize = 2;

/// All around, from the highest beam; the column of each tick.
pub struct Screen {
    width: usize,
    height: usize,
    /// Row by row, meters; 0 = no return.
    ranges: Vec<f32>,
    /// In which turn each column was measured last.
    turns: Vec<Option<u16>>,
    newest: u16,
    drawn: Option<Instant>,
}

impl Screen {
    /// `None` where stdout is no terminal.
    pub fn on_terminal() -> Option<Self> {
        if !io::stdout().is_terminal() {
            return None;
        }
        let (lines, columns) = Term::stdout().size();
        let height = 2 * usize::from(lines).saturating_sub(LINES + 1).clamp(1, 32);
        Some(Self::new(usize::from(columns).clamp(20, 400), height))
    }

    fn new(width: usize, height: usize) -> Self {
        let (ranges, turns) = (vec![0.0; width * height], vec![None; width]);
        Self { width, height, ranges, turns, newest: 0, drawn: None }
    }

    /// Puts a strip's columns where they look.
    pub fn take(&mut self, strip: &ReceivedStrip) {
        let (rows, ticks) = (strip.rows().max(1), strip.ticks_a_turn().max(1) as usize);
        self.newest = strip.turn();
        for (tick, levels) in strip.columns() {
            let x = (usize::from(tick) * self.width / ticks).min(self.width - 1);
            self.turns[x] = Some(strip.turn());
            for y in 0..self.height {
                let level = levels.get(y * rows / self.height).copied().unwrap_or(0);
                self.ranges[y * self.width + x] = f32::from(level) * strip.level_m();
            }
        }
    }

    /// Draws it, if it is time to, with lines of text below.
    pub fn draw(&mut self, now: Instant, lines: [&str; LINES]) -> Result<(), Failure> {
        if self.drawn.is_some_and(|drawn| now.duration_since(drawn) < INTERVAL) {
            return Ok(());
        }
        let is_first = self.drawn.replace(now).is_none();
        // The whole screen cleared and the cursor hidden, or back to the upper left corner.
        let begin = if is_first { "\x1b[?25l\x1b[2J\x1b[H" } else { "\x1b[H" };
        let mut text = begin.to_owned();
        self.push_picture(&mut text);
        for line in lines {
            // What does not fit the line would make two of it.
            let line: String = line.chars().take(self.width).collect();
            let _ = write!(text, "{line}\x1b[K\r\n");
        }
        let mut stdout = io::stdout().lock();
        stdout.write_all(text.as_bytes())?;
        Ok(stdout.flush()?)
    }

    /// Shows the cursor again.
    pub fn end(&self) -> Result<(), Failure> {
        if self.drawn.is_some() {
            io::stdout().write_all(b"\x1b[?25h")?;
        }
        Ok(())
    }

    /// Two rows a line: the upper and the lower half of each character.
    fn push_picture(&self, text: &mut String) {
        for y in (0..self.height).step_by(2) {
            for x in 0..self.width {
                let [[r, g, b], [lower_r, lower_g, lower_b]] = [self.color(x, y), self.color(x, y + 1)];
                let _ = write!(text, "\x1b[38;2;{r};{g};{b};48;2;{lower_r};{lower_g};{lower_b}m\u{2580}");
            }
            text.push_str("\x1b[0m\r\n");
        }
    }

    /// Black is no return, or nothing received for a turn.
    fn color(&self, x: usize, y: usize) -> [u8; 3] {
        let is_new = self.turns[x].is_some_and(|turn| self.newest.wrapping_sub(turn) <= 1);
        match self.ranges.get(y * self.width + x) {
            Some(&range_m) if is_new && range_m > 0.0 => color::of_range(range_m),
            _ => [0; 3],
        }
    }
}

#[cfg(test)]
mod tests {
    use flicr::coder::ContextSettings;
    use flicr::geometry::sensors::hdl64e;
    use flicr::stream::{StreamConfig, StreamDecoder, StreamEncoder};

    use super::{Screen, color};

    /// One column is drawn where its tick is, in the color of its range.
    #[test]
    fn columns_are_where_they_look() {
        let config = StreamConfig::new(&hdl64e::FIRING_GRID, 1, ContextSettings::FINE).unwrap();
        let mut stream: StreamEncoder = StreamEncoder::new(config).unwrap();
        let (mut decoder, mut screen) = (StreamDecoder::default(), Screen::new(40, 4));
        stream.push_counts(0, 2000, 0, &[2500; 64], |_| {});
        stream.end_turn(|datagram| screen.take(decoder.push(datagram).unwrap()));
        let five_meters = color::of_range(5.0);
        for x in 0..40 {
            let expected = if x == 20 { five_meters } else { [0; 3] };
            assert!((0..4).all(|y| screen.color(x, y) == expected), "{x}");
        }
        let mut text = String::new();
        screen.push_picture(&mut text);
        assert_eq!((text.matches('\u{2580}').count(), text.matches('\n').count()), (80, 2));
    }
}
