//! Things that a ray can meet, and where it meets them.

/// A half line: `origin + range * direction`, the direction of length 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub(super) origin: [f64; 3],
    pub(super) direction: [f64; 3],
}

impl Ray {
    pub(super) fn at(&self, range_m: f64) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.origin[axis] + range_m * self.direction[axis])
    }
}

/// A stretch of a ray inside a solid, and how squarely the ray met its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) enter_m: f64,
    pub(super) leave_m: f64,
    /// Cosine of the angle between the ray and the surface's normal: 1 is square on.
    pub(super) cos_incidence: f64,
    /// True where the ray met a side, false where it met the top or bottom.
    pub(super) side: bool,
    /// Where along the side, in meters from its middle.
    pub(super) along_m: f64,
}

/// The forms of the street's furniture; all stand upright.
#[derive(Clone, Copy, Debug)]
pub(super) enum Form {
    /// Half length, half width and half height, turned by the angle of this cosine and sine.
    Box { half: [f64; 3], heading: [f64; 2] },
    /// Radius and half height.
    Cylinder { radius: f64, half_height: f64 },
    /// Half axes.
    Ellipsoid { half: [f64; 3] },
}

/// A form at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub(super) center: [f64; 3],
    pub(super) form: Form,
}

impl Shape {
    /// An upright box between two heights.
    pub(super) fn upright(center: [f64; 2], half: [f64; 2], heights: [f64; 2], heading: [f64; 2]) -> Self {
        Self {
            center: [center[0], center[1], f64::midpoint(heights[0], heights[1])],
            form: Form::Box { half: [half[0], half[1], (heights[1] - heights[0]) / 2.0], heading },
        }
    }

    /// An upright cylinder between two heights.
    pub(super) fn cylinder(center: [f64; 2], radius: f64, heights: [f64; 2]) -> Self {
        Self {
            center: [center[0], center[1], f64::midpoint(heights[0], heights[1])],
            form: Form::Cylinder { radius, half_height: (heights[1] - heights[0]) / 2.0 },
        }
    }

    /// The part of the ray inside, if it passes through from outside.
    pub(super) fn span(&self, ray: &Ray) -> Option<Span> {
        let offset = [0, 1, 2].map(|axis| ray.origin[axis] - self.center[axis]);
        match self.form {
            Form::Box { half, heading } => box_span(offset, ray.direction, half, heading),
            Form::Cylinder { radius, half_height } => cylinder_span(offset, ray.direction, radius, half_height),
            Form::Ellipsoid { half } => ellipsoid_span(offset, ray.direction, half),
        }
    }

    /// Corners, in the plan, of a rectangle around the shape that is `margin_m` larger all round.
    pub(super) fn footprint(&self, margin_m: f64) -> [[f64; 2]; 4] {
        let (half, [cos, sin]) = match self.form {
            Form::Box { half, heading } => ([half[0], half[1]], heading),
            Form::Cylinder { radius, .. } => ([radius; 2], [1.0, 0.0]),
            Form::Ellipsoid { half } => ([half[0], half[1]], [1.0, 0.0]),
        };
        [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]].map(|[along, across]| {
            let u = along * (half[0] + margin_m);
            let w = across * (half[1] + margin_m);
            [self.center[0] + cos * u - sin * w, self.center[1] + sin * u + cos * w]
        })
    }
}

/// Turns a plan vector into the frame of a box.
fn turned_back([x, y]: [f64; 2], [cos, sin]: [f64; 2]) -> [f64; 2] {
    [cos * x + sin * y, cos * y - sin * x]
}

fn box_span(offset: [f64; 3], direction: [f64; 3], half: [f64; 3], heading: [f64; 2]) -> Option<Span> {
    let [ox, oy] = turned_back([offset[0], offset[1]], heading);
    let [dx, dy] = turned_back([direction[0], direction[1]], heading);
    let (o, d) = ([ox, oy, offset[2]], [dx, dy, direction[2]]);
    let (mut enter_m, mut leave_m, mut face) = (0.0, f64::INFINITY, 3);
    for axis in 0..3 {
        let (near, far) = slab(o[axis], d[axis], half[axis])?;
        if near > enter_m {
            (enter_m, face) = (near, axis);
        }
        leave_m = far.min(leave_m);
    }
    if face == 3 || enter_m >= leave_m {
        return None;
    }
    let along_axis = 1 - face.min(1);
    Some(Span {
        enter_m,
        leave_m,
        cos_incidence: d[face].abs(),
        side: face != 2,
        along_m: o[along_axis] + enter_m * d[along_axis],
    })
}

/// Where a line is between two planes at -half and +half; nothing if it never is.
fn slab(offset: f64, direction: f64, half: f64) -> Option<(f64, f64)> {
    if direction == 0.0 {
        return (offset.abs() <= half).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let inverse = 1.0 / direction;
    let (one, other) = ((-half - offset) * inverse, (half - offset) * inverse);
    Some((one.min(other), one.max(other)))
}

fn cylinder_span(offset: [f64; 3], direction: [f64; 3], radius: f64, half_height: f64) -> Option<Span> {
    let flat = direction[0] * direction[0] + direction[1] * direction[1];
    let toward = offset[0] * direction[0] + offset[1] * direction[1];
    let beside = offset[0] * offset[0] + offset[1] * offset[1] - radius * radius;
    let (round_in, round_out) = roots(flat, toward, beside)?;
    let (flat_in, flat_out) = slab(offset[2], direction[2], half_height)?;
    let enter_m = round_in.max(flat_in);
    let leave_m = round_out.min(flat_out);
    if enter_m <= 0.0 || enter_m >= leave_m {
        return None;
    }
    let side = round_in >= flat_in;
    let cos_incidence = if side { (toward + enter_m * flat).abs() / radius } else { direction[2].abs() };
    Some(Span { enter_m, leave_m, cos_incidence, side, along_m: 0.0 })
}

fn ellipsoid_span(offset: [f64; 3], direction: [f64; 3], half: [f64; 3]) -> Option<Span> {
    let o = [0, 1, 2].map(|axis| offset[axis] / half[axis]);
    let d = [0, 1, 2].map(|axis| direction[axis] / half[axis]);
    let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let toward = o[0] * d[0] + o[1] * d[1] + o[2] * d[2];
    let outside = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - 1.0;
    let (enter_m, leave_m) = roots(square, toward, outside)?;
    (enter_m > 0.0).then_some(Span { enter_m, leave_m, cos_incidence: 1.0, side: true, along_m: 0.0 })
}

/// Roots of `a t² + 2 b t + c`, the smaller first.
fn roots(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    let discriminant = b * b - a * c;
    if discriminant <= 0.0 || a == 0.0 {
        return None;
    }
    let root = libm::sqrt(discriminant);
    Some(((-b - root) / a, (-b + root) / a))
}

#[cfg(test)]
mod tests {
    use super::{Form, Ray, Shape};

    const FORWARD: Ray = Ray { origin: [0.0, 0.0, 1.0], direction: [1.0, 0.0, 0.0] };

    #[test]
    fn a_ray_meets_a_box_at_its_near_face() {
        let shape = Shape::upright([10.0, 0.5], [2.0, 1.0], [0.0, 3.0], [1.0, 0.0]);
        let span = shape.span(&FORWARD).expect("straight ahead");
        assert_eq!((span.enter_m, span.leave_m), (8.0, 12.0));
        assert_eq!((span.cos_incidence, span.along_m), (1.0, -0.5));
    }

    #[test]
    fn a_ray_meets_a_cylinder_and_an_ellipsoid_at_their_near_points() {
        let trunk = Shape::cylinder([10.0, 0.0], 0.5, [0.0, 3.0]);
        assert_eq!(trunk.span(&FORWARD).map(|span| span.enter_m), Some(9.5));
        let crown = Shape { center: [10.0, 0.0, 1.0], form: Form::Ellipsoid { half: [2.0, 3.0, 4.0] } };
        assert_eq!(crown.span(&FORWARD).map(|span| span.enter_m), Some(8.0));
    }

    #[test]
    fn a_ray_passes_what_is_behind_beside_or_above() {
        for (x, y, heights) in [(-10.0, 0.0, [0.0, 3.0]), (10.0, 2.0, [0.0, 3.0]), (10.0, 0.0, [2.0, 3.0])] {
            let shape = Shape::upright([x, y], [1.0, 1.0], heights, [1.0, 0.0]);
            assert!(shape.span(&FORWARD).is_none());
            assert!(Shape::cylinder([x, y], 1.0, heights).span(&FORWARD).is_none());
        }
    }
}
