//! Which photons around a query lie on its surface, and how much of that surface is within the radius.
//!
//! A disc about a point near an edge hangs over it: divided by the whole disc, an estimate is too dark there, and photons of the
//! other wall, or of the other side of a thin one, make it too bright again or wrong. [`SURFACE_OWN`] counts the photons of the query's own
//! primitive alone and divides by the part of the disc that lies on it, which is known where a primitive is a quad or a sphere: then
//! an even irradiance is estimated exactly, at edges and in corners as well. (Hey and Purgathofer, "Advanced Radiance
//! Estimation for Photon Map Global Illumination", Eurographics 2002, divide by the area of the real geometry within the
//! sphere, too.) Of a mesh, whose triangles may be smaller than the disc, the photons of [`SURFACE_FACING`] count, and the disc is whole.

use super::filter::{FILTER_CONSTANT, filter_integral};
use crate::exec::{Input, Update};
use crate::grid::Grid;
use crate::layout::{Arrival, Site};
use crate::num::{abs, div, max, pcg4d, sin_cos_turns, u32_to_unit};
use crate::trace::vector::{cross, dot, from_frame, pack_direction, unpack_direction};
use crate::trace::{PRIMITIVE_QUAD, PRIMITIVE_SPHERE, Primitive};
use glam::Vec3;

/// Every photon within the radius counts.
pub const SURFACE_ANY: u32 = 0;
/// Photons count that arrived on the side that is seen, on a surface that faces alike, near the query's tangent plane.
pub const SURFACE_FACING: u32 = 1;
/// Photons count that arrived on the side that is seen of the query's own quad or sphere.
pub const SURFACE_OWN: u32 = 2;

/// Least cosine between the normals of surfaces that face alike: 45°.
const ALIKE: f32 = core::f32::consts::FRAC_1_SQRT_2;
/// Largest squared distance from the tangent plane, in squared radii: within it lie all photons of a sphere of twice the radius.
const FLAT2: f32 = 1.0 / 16.0;
/// Directions in which the edge of a quad is looked for. Opposite ones are among them, and those at right angles, so that half discs
/// at edges and quarters in corners are exact. Elsewhere the area is off by 1 % or so; the directions of each point are turned by
/// chance, so that it is right on average.
const DIRECTIONS: u32 = 32;
/// Least part of a disc that is divided by: rounding may leave a point of an edge with nothing.
const LEAST_PART: f32 = 1e-3;
/// What the random turn of directions is drawn with.
const TURN_KEY: u32 = 0x5f1a_0010;

/// The unit normal of a primitive at one of its points: a quad's front side, a sphere's outside.
#[inline]
fn normal_at(primitive: &Primitive, point: Vec3) -> Vec3 {
    if primitive.kind == PRIMITIVE_SPHERE {
        let radius = point - Vec3::from_array(primitive.position);
        radius * div(1.0, max(primitive.size, 1e-30))
    } else {
        Vec3::from_array(primitive.normal)
    }
}

/// Writes down for the `i`-th photon of a sorted map on which side of its surface it arrived: the normal of that side.
#[inline]
pub fn face_arrivals<A: Update<Arrival> + ?Sized>(
    i: u32,
    grid: &Grid,
    primitives: &Input<Primitive>,
    sites: &Input<Site>,
    arrivals: &mut A,
) {
    if i >= grid.photons {
        return;
    }
    let arrival = arrivals.get(i);
    let point = Vec3::from_array(sites[i as usize].position());
    let normal = normal_at(&primitives[arrival.primitive() as usize], point);
    let direction = unpack_direction(arrival.direction());
    let side = if dot(direction, normal) > 0.0 { -normal } else { normal };
    arrivals.set(i, arrival.with_side(pack_direction(side)));
}

/// Where a query looks for photons, and which count.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// [`SURFACE_ANY`], [`SURFACE_FACING`] or [`SURFACE_OWN`].
    pub(super) surface: u32,
    /// Index of the query's primitive.
    pub(super) primitive: u32,
    pub(super) position: Vec3,
    /// Unit normal of the side that is seen.
    pub(super) normal: Vec3,
    /// Squared radius, m².
    pub(super) radius2: f32,
}

impl Place {
    /// Whether a photon within the radius lies on the surface.
    #[inline]
    pub(super) fn has(&self, site: Site, arrival: Arrival) -> bool {
        if self.surface == SURFACE_ANY {
            return true;
        }
        let alike = dot(unpack_direction(arrival.side()), self.normal);
        if self.surface == SURFACE_OWN {
            return arrival.primitive() == self.primitive && alike > 0.0;
        }
        let height = dot(Vec3::from_array(site.position()) - self.position, self.normal);
        alike >= ALIKE && height * height <= self.radius2 * FLAT2
    }
}

/// W for the part of the disc of squared radius `radius2` about a point that lies on its quad or sphere: W(1) times that part
/// for a constant filter; in general the mean of W(R²/r²) over all directions, R being how far the surface goes.
#[inline]
pub(super) fn part_on(primitive: &Primitive, position: Vec3, radius2: f32, filter: u32) -> f32 {
    let whole = filter_integral(filter, 1.0);
    if primitive.kind == PRIMITIVE_SPHERE {
        // The part of a sphere within the distance s of one of its points has the area π·s², up to the point opposite.
        let farthest2 = 4.0 * primitive.size * primitive.size;
        return if farthest2 < radius2 { filter_integral(filter, div(farthest2, radius2)) } else { whole };
    }
    let local = position - Vec3::from_array(primitive.position);
    let (dual_u, dual_v) = (Vec3::from_array(primitive.sides[0]), Vec3::from_array(primitive.sides[1]));
    let (u, v) = (dot(local, dual_u), dot(local, dual_v));
    // Squared distances to the nearer edges, over those of a whole edge.
    let rest_u = max(0.0, 0.5 - abs(u));
    let rest_v = max(0.0, 0.5 - abs(v));
    if rest_u * rest_u >= radius2 * dot(dual_u, dual_u) && rest_v * rest_v >= radius2 * dot(dual_v, dual_v) {
        return whole;
    }
    let normal = Vec3::from_array(primitive.normal);
    let x_axis = from_frame(normal, 1.0, 0.0, 0.0);
    let y_axis = cross(normal, x_axis);
    let words = [position.x.to_bits(), position.y.to_bits(), position.z.to_bits(), TURN_KEY];
    let turn = u32_to_unit(pcg4d(words)[0]);
    let mut sum = 0.0;
    let mut n = 0;
    while n < DIRECTIONS {
        let (sin, cos) = sin_cos_turns((n as f32 + turn) * (1.0 / DIRECTIONS as f32));
        let direction = x_axis * cos + y_axis * sin;
        let (du, dv) = (dot(direction, dual_u), dot(direction, dual_v));
        // How far the edges are: rest / |d|, the nearer of two found without dividing.
        let to_u = if du > 0.0 { 0.5 - u } else { 0.5 + u };
        let to_v = if dv > 0.0 { 0.5 - v } else { 0.5 + v };
        let u_first = to_u * abs(dv) < to_v * abs(du);
        let rest = max(0.0, if u_first { to_u } else { to_v });
        let slope = if u_first { abs(du) } else { abs(dv) };
        let x = if rest * rest >= slope * slope * radius2 { 1.0 } else { div(rest * rest, slope * slope * radius2) };
        sum += if filter == FILTER_CONSTANT { x } else { filter_integral(filter, x) };
        n += 1;
    }
    max(sum * (1.0 / DIRECTIONS as f32), whole * LEAST_PART)
}

/// Whether the part of a disc on this kind of primitive is known.
#[inline]
pub(super) fn is_known(primitive: &Primitive) -> bool {
    primitive.kind == PRIMITIVE_QUAD || primitive.kind == PRIMITIVE_SPHERE
}

#[cfg(test)]
mod tests {
    use super::super::filter::{FILTER_CONE, FILTER_EPANECHNIKOV, FILTER_GAUSSIAN, filter_weight};
    use super::*;
    use crate::trace::NO_LIGHT;

    /// A quad of edges `u` and `v` about the origin.
    fn quad(u: Vec3, v: Vec3) -> Primitive {
        let normal = u.cross(v);
        let square = normal.dot(normal);
        Primitive {
            kind: PRIMITIVE_QUAD,
            light: NO_LIGHT,
            normal: normal.normalize().to_array(),
            sides: [(v.cross(normal) / square).to_array(), (normal.cross(u) / square).to_array()],
            ..Primitive::default()
        }
    }

    /// ∫ w dA over the part of the disc on the quad, over π·r², by midpoints.
    fn by_midpoints(u: Vec3, v: Vec3, at: [f32; 2], radius: f32, filter: u32) -> f64 {
        const STEPS: i32 = 600;
        let mut sum = 0.0;
        let centre = u * at[0] + v * at[1];
        let (nu, nv) = (u.normalize(), u.cross(v).cross(u).normalize());
        let primitive = quad(u, v);
        let duals = primitive.sides.map(Vec3::from_array);
        for i in 0..STEPS {
            for j in 0..STEPS {
                let [x, y] = [i, j].map(|i| (i as f32 + 0.5) * 2.0 / STEPS as f32 - 1.0);
                let x2 = x * x + y * y;
                let point = centre + (nu * x + nv * y) * radius;
                if x2 <= 1.0 && point.dot(duals[0]).abs() <= 0.5 && point.dot(duals[1]).abs() <= 0.5 {
                    sum += f64::from(filter_weight(filter, x2));
                }
            }
        }
        sum * 4.0 / f64::from(STEPS * STEPS) / std::f64::consts::PI
    }

    #[test]
    fn the_part_of_a_disc_on_a_quad_is_the_area_there() {
        let square = (Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 0.0, -2.0));
        let skewed = (Vec3::new(1.5, 0.4, 0.0), Vec3::new(0.3, 1.1, 0.6));
        for filter in [FILTER_CONSTANT, FILTER_CONE, FILTER_GAUSSIAN, FILTER_EPANECHNIKOV] {
            let whole = filter_integral(filter, 1.0);
            for (u, v) in [square, skewed] {
                let primitive = quad(u, v);
                for at in [[0.0, 0.0], [0.5, 0.0], [0.49, 0.1], [-0.47, 0.3], [0.45, -0.44], [-0.5, -0.5], [0.41, 0.2]]
                {
                    for radius in [0.05, 0.2, 0.7, 5.0] {
                        let expected = by_midpoints(u, v, at, radius, filter) / f64::from(whole);
                        // The same place but for roundings: each has other directions.
                        let found = |i: u32| {
                            let position = (u * at[0] + v * at[1]) * (1.0 - i as f32 * 3e-7);
                            f64::from(part_on(&primitive, position, radius * radius, filter)) / f64::from(whole)
                        };
                        let all: std::vec::Vec<f64> = (0..256).map(found).collect();
                        let mean = all.iter().sum::<f64>() / 256.0;
                        let worst = all.iter().map(|found| (found - expected).abs()).fold(0.0, f64::max);
                        // A step that 32 directions find to within one of them on either side; 256 turns of 2 % at most;
                        // and by_midpoints to within a row of its 600.
                        assert!(
                            worst < 2.0 / 32.0 && (mean - expected).abs() < 0.003,
                            "filter {filter}, {at:?}, radius {radius}: {mean} and {expected}, off by {worst} at most"
                        );
                    }
                }
                // Half discs at edges, whatever their direction, and quarters in right corners are exact.
                let half = part_on(&primitive, u * 0.5, 0.0025, filter);
                assert!((half / whole - 0.5).abs() < 1e-4, "{filter}: {half}");
            }
            let (u, v) = square;
            let quarter = part_on(&quad(u, v), (u + v) * 0.5, 0.0025, filter);
            assert!((quarter / whole - 0.25).abs() < 1e-4, "{filter}: {quarter}");
        }
    }

    #[test]
    fn a_sphere_fills_discs_up_to_its_other_side() {
        let ball = Primitive { kind: PRIMITIVE_SPHERE, size: 1.0, ..Primitive::default() };
        assert_eq!(part_on(&ball, Vec3::X, 3.9, FILTER_CONSTANT), 1.0);
        // All of its 4π within the radius 4: a quarter of the disc π·16.
        assert_eq!(part_on(&ball, Vec3::X, 16.0, FILTER_CONSTANT), 0.25);
    }

    #[test]
    fn sides_and_surfaces_that_do_not_face_the_query_are_left_out() {
        let place =
            Place { surface: SURFACE_FACING, primitive: 3, position: Vec3::ZERO, normal: Vec3::Y, radius2: 1.0 };
        let on = |primitive: u32, side: Vec3| {
            Arrival::new([0; 3], [0; 3], [0; 3], 0, primitive).with_side(pack_direction(side))
        };
        let here = Site::new([0.3, 0.0, 0.0], 0);
        let above = Site::new([0.3, 0.26, 0.0], 0);
        assert!(place.has(here, on(9, Vec3::Y)), "another primitive that faces alike");
        assert!(!place.has(here, on(3, -Vec3::Y)), "the other side");
        assert!(!place.has(here, on(9, Vec3::X)), "a wall at a right angle");
        assert!(!place.has(above, on(9, Vec3::Y)), "a step");
        let own = Place { surface: SURFACE_OWN, ..place };
        assert!(own.has(here, on(3, Vec3::Y)) && !own.has(here, on(9, Vec3::Y)) && !own.has(here, on(3, -Vec3::Y)));
        let any = Place { surface: SURFACE_ANY, ..place };
        assert!(any.has(above, on(9, -Vec3::Y)));
    }
}
