//! Points from above.

use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::{DrawTargetExt, Drawable, Point, Primitive, Size};
use embedded_graphics::primitives::{Circle, PrimitiveStyle, Rectangle};

use super::color::HeightScale;
use crate::canvas::{Area, Canvas};

const GROUND: [u8; 3] = [0, 0, 0];
const RING: Rgb888 = Rgb888::new(58, 62, 70);

/// Enough to fill a panel that is twice as wide as high.
const RINGS: u8 = 12;

/// Share of the points that a panel must show.
const SHOWN: f32 = 0.96;

/// Half the height of a panel, meters: a round number within which nearly all points lie.
pub fn radius_m(points: &[[f32; 3]]) -> f32 {
    let mut distances: Vec<f32> = points.iter().map(|&[x, y, _]| x.abs().max(y.abs())).collect();
    distances.sort_by(f32::total_cmp);
    let most = distances.get((distances.len() as f32 * SHOWN) as usize).copied().unwrap_or_default();
    let rounds = [2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 150.0, 200.0, 300.0];
    rounds.into_iter().find(|&round| round >= most).unwrap_or(most)
}

/// Round distances, at most five of them from the middle to the panel's edge.
fn ring_spacing_m(radius_m: f32) -> f32 {
    let rounds = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
    rounds.into_iter().find(|&round| radius_m / round <= 5.0).unwrap_or(radius_m / 4.0)
}

/// Draws points with the sensor in the middle, x to the right, y up; the highest of a pixel is seen.
pub fn draw(canvas: &mut Canvas, area: Area, points: &[[f32; 3]], heights: HeightScale, radius_m: f32) {
    canvas.fill(area, GROUND);
    let panel = Panel { area, pixels_per_m: area.height as f32 / (2.0 * radius_m) };
    panel.draw_rings(canvas, ring_spacing_m(radius_m));
    let mut by_height: Vec<&[f32; 3]> = points.iter().collect();
    by_height.sort_by(|a, b| a[2].total_cmp(&b[2]));
    for &&[x, y, z] in &by_height {
        if let Some((x, y)) = panel.pixel(x, y) {
            canvas.set(x, y, heights.color(z));
        }
    }
    panel.draw_ring_labels(canvas, ring_spacing_m(radius_m));
}

struct Panel {
    area: Area,
    pixels_per_m: f32,
}

impl Panel {
    fn middle(&self) -> (u32, u32) {
        (self.area.x + self.area.width / 2, self.area.y + self.area.height / 2)
    }

    fn pixel(&self, x_m: f32, y_m: f32) -> Option<(u32, u32)> {
        let x = self.area.width as f32 / 2.0 + x_m * self.pixels_per_m;
        let y = self.area.height as f32 / 2.0 - y_m * self.pixels_per_m;
        let inside = x >= 0.0 && y >= 0.0 && x < self.area.width as f32 && y < self.area.height as f32;
        // Only then: what lies far outside does not fit the sum.
        inside.then(|| (self.area.x + x as u32, self.area.y + y as u32))
    }

    /// Circles around the sensor, out to the panel's corners.
    fn draw_rings(&self, canvas: &mut Canvas, every_m: f32) {
        let Area { x, y, width, height } = self.area;
        let corner = Point::new(x.cast_signed(), y.cast_signed());
        let mut clipped = canvas.clipped(&Rectangle::new(corner, Size::new(width, height)));
        let (x, y) = self.middle();
        for ring in 1..=RINGS {
            let diameter = (2.0 * self.pixels_per_m * every_m * f32::from(ring)) as u32;
            let middle = Point::new(x.cast_signed(), y.cast_signed());
            let Ok(()) = Circle::with_center(middle, diameter)
                .into_styled(PrimitiveStyle::with_stroke(RING, 1))
                .draw(&mut clipped);
        }
    }

    /// Meters of the rings, below the sensor.
    fn draw_ring_labels(&self, canvas: &mut Canvas, every_m: f32) {
        let (x, y) = self.middle();
        for ring in 1..=3_u8 {
            let meters = every_m * f32::from(ring);
            let label = format!("{meters} m");
            let y = y + (self.pixels_per_m * meters) as u32;
            let half = 4 * label.len() as u32 + 2;
            canvas.fill(Area { x: x - half, y: y - 7, width: 2 * half, height: 14 }, GROUND);
            canvas.centered_text(x, y - 6, &label);
        }
    }
}
