//! A picture in memory that embedded-graphics can draw on.

use std::convert::Infallible;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use embedded_graphics::mono_font::{MonoTextStyle, ascii::FONT_8X13};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::{DrawTarget, Drawable, OriginDimensions, Pixel, Point, RgbColor, Size, WebColors};
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};

/// A rectangle of the canvas, pixels.
#[derive(Debug, Clone, Copy)]
pub struct Area {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl Area {
    /// Left and right half with a gap between.
    pub const fn halves(self, gap: u32) -> [Self; 2] {
        let width = (self.width - gap) / 2;
        [Self { width, ..self }, Self { x: self.x + self.width - width, width, ..self }]
    }
}

/// RGB pixels, row-major.
pub struct Canvas {
    size: Size,
    rgb: Vec<u8>,
}

/// Around the panels.
const BACKGROUND: [u8; 3] = [24, 26, 30];
/// Of labels.
const INK: Rgb888 = Rgb888::CSS_LIGHT_GRAY;

impl Canvas {
    pub fn new(width: u32, height: u32) -> Self {
        Self { size: Size::new(width, height), rgb: BACKGROUND.repeat((width * height) as usize) }
    }

    /// Sets a pixel; those outside are none.
    pub fn set(&mut self, x: u32, y: u32, rgb: [u8; 3]) {
        if x < self.size.width
            && let Some(pixel) = self.rgb.as_chunks_mut().0.get_mut((y * self.size.width + x) as usize)
        {
            *pixel = rgb;
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, area: Area, rgb: [u8; 3]) {
        for y in area.y..area.y + area.height {
            for x in area.x..area.x + area.width {
                self.set(x, y, rgb);
            }
        }
    }

    /// Text with its upper left corner at (x, y).
    pub fn text(&mut self, x: u32, y: u32, text: &str) {
        self.aligned_text(x, y, text, Alignment::Left);
    }

    /// Text with the middle of its upper edge at (x, y).
    pub fn centered_text(&mut self, x: u32, y: u32, text: &str) {
        self.aligned_text(x, y, text, Alignment::Center);
    }

    fn aligned_text(&mut self, x: u32, y: u32, text: &str, alignment: Alignment) {
        let style = TextStyleBuilder::new().alignment(alignment).baseline(Baseline::Top).build();
        let at = Point::new(x.cast_signed(), y.cast_signed());
        let Ok(_) = Text::with_text_style(text, at, MonoTextStyle::new(&FONT_8X13, INK), style).draw(self);
    }

    /// Writes the picture as a PNG.
    pub fn write_png(&self, path: &Path) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), self.size.width, self.size.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        self.size
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(Point { x, y }, color) in pixels {
            if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) {
                self.set(x, y, [color.r(), color.g(), color.b()]);
            }
        }
        Ok(())
    }
}
