//! At what each light aims its photons for the caustic map (Jensen's projection maps, "Realistic Image Synthesis Using Photon Mapping", 2001,
//! section 5.2.1, with spheres in place of pixels).

use super::content::{NOTHING, Shape, Surface};
use caustic_kernels::trace::{LIGHT_AREA, LIGHT_DISC, LIGHT_SPOT, LIGHT_TRIANGLE, Light, Target};
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// Most targets: a photon looks at all that its light sees.
const MOST: usize = 128;

/// Surfaces that one sphere encloses, each with its place in the scene.
struct Cluster<'a> {
    surfaces: Vec<(usize, &'a Surface)>,
    target: Target,
}

impl<'a> Cluster<'a> {
    fn new(surfaces: Vec<(usize, &'a Surface)>) -> Self {
        let target = match surfaces[..] {
            [(_, surface)] => around(surface),
            _ => {
                let bounds = surfaces.iter().map(|(_, surface)| surface.bounds());
                boxed(bounds.fold(NOTHING, |all, one| (all.0.min(one.0), all.1.max(one.1))))
            }
        };
        Self { surfaces, target }
    }

    /// Its halves along the axis on which it is longest.
    fn split(&self) -> Option<[Self; 2]> {
        if self.surfaces.len() < 2 {
            return None;
        }
        let middle = |(_, surface): &(usize, &Surface)| {
            let (low, high) = surface.bounds();
            low + high
        };
        let middles = self.surfaces.iter().map(middle);
        let (low, high) = middles.fold(NOTHING, |all, one| (all.0.min(one), all.1.max(one)));
        let axis = (high - low).max_position();
        let mut sorted = self.surfaces.clone();
        sorted.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        let rest = sorted.split_off(sorted.len() / 2);
        Some([Self::new(sorted), Self::new(rest)])
    }

    /// How much of the light it catches that is aimed at it: what counts is the cross section.
    fn size(&self) -> f32 {
        self.target.radius * self.target.radius
    }
}

/// Spheres around all surfaces that are not purely diffuse. What is not a triangle has its own, and a mesh as many as make the
/// sum of their cross sections smaller; where that is too many, neighbours share one.
pub(super) fn targets<'a>(surfaces: impl Iterator<Item = &'a Surface>) -> Vec<Target> {
    let mut groups = Vec::new();
    let mut meshes: BTreeMap<u32, Vec<(usize, &Surface)>> = BTreeMap::new();
    for (place, surface) in surfaces.enumerate() {
        if matches!(surface.shape, Shape::Triangle { .. }) {
            meshes.entry(surface.object).or_default().push((place, surface));
        } else {
            groups.push(vec![(place, surface)]);
        }
    }
    groups.extend(meshes.into_values());
    let too_many = groups.len() > MOST;
    if too_many {
        groups = vec![groups.concat()];
    }
    let mut finished = Vec::new();
    let mut clusters: Vec<Cluster<'_>> = groups.into_iter().map(Cluster::new).collect();
    while !clusters.is_empty() && clusters.len() + finished.len() < MOST {
        let sizes = clusters.iter().map(Cluster::size).enumerate();
        let Some((largest, _)) = sizes.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        let cluster = clusters.swap_remove(largest);
        match cluster.split() {
            Some(halves) if too_many || halves[0].size() + halves[1].size() < cluster.size() => clusters.extend(halves),
            _ => finished.push(cluster),
        }
    }
    finished.extend(clusters);
    // In the order of the scene, whatever the order in which they were split.
    finished.sort_by_key(|cluster| cluster.surfaces.iter().map(|(place, _)| *place).min());
    finished.iter().map(|cluster| cluster.target).collect()
}

/// The smallest sphere around a surface.
fn around(surface: &Surface) -> Target {
    match surface.shape {
        Shape::Sphere { centre, radius } => Target { centre: centre.as_vec3().to_array(), radius: radius as f32 },
        Shape::Quad { corner, edge_u, edge_v } => Target {
            centre: (corner + (edge_u + edge_v) / 2.0).as_vec3().to_array(),
            radius: ((edge_u + edge_v).length().max((edge_u - edge_v).length()) / 2.0) as f32,
        },
        Shape::Disc { .. } | Shape::Triangle { .. } => boxed(surface.bounds()),
    }
}

/// The sphere around a box.
pub(super) fn boxed((low, high): (DVec3, DVec3)) -> Target {
    Target { centre: ((low + high) / 2.0).as_vec3().to_array(), radius: ((high - low).length() / 2.0) as f32 }
}

/// Gives each light the targets that it can see, one list after another; lights that see the same share a list.
pub(super) fn aim(lights: &mut [Light], targets: &[Target]) -> Vec<Target> {
    let mut lists: BTreeMap<Vec<usize>, u32> = BTreeMap::new();
    let mut all = Vec::new();
    for light in lights {
        let seen: Vec<usize> = (0..targets.len()).filter(|&i| can_see(light, &targets[i])).collect();
        light.targets = seen.len() as u32;
        light.first_target = *lists.entry(seen).or_insert_with_key(|seen| {
            let first = all.len() as u32;
            all.extend(seen.iter().map(|&i| targets[i]));
            first
        });
    }
    all
}

/// Whether any of the light's rays may meet the target. What stands between them is not looked at.
fn can_see(light: &Light, target: &Target) -> bool {
    // A target's numbers are rounded; who knows how far its surfaces reach beyond them.
    let radius = target.radius * 1.001;
    let to_target = Vec3::from_array(target.centre) - Vec3::from_array(light.position);
    let normal = Vec3::from_array(light.normal);
    match light.kind {
        LIGHT_AREA | LIGHT_TRIANGLE | LIGHT_DISC => to_target.dot(normal) > -radius,
        LIGHT_SPOT => {
            let distance = to_target.length();
            let half_angle = (1.0 - light.edges[0][1]).acos();
            distance <= radius || to_target.angle_between(normal) <= half_angle + (radius / distance).asin() + 1e-3
        }
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_kernels::trace::LIGHT_POINT;

    fn ball(x: f64) -> Surface {
        let shape = Shape::Sphere { centre: DVec3::new(x, 0.0, 0.0), radius: 0.5 };
        Surface { shape, material: 0, radiance: None, object: 0, has_corners: false }
    }

    fn strip(n: u32) -> Vec<Surface> {
        let triangle = |i: u32| {
            let x = f64::from(i);
            let corners = [DVec3::new(x, 0.0, 0.0), DVec3::new(x + 1.0, 0.0, 0.0), DVec3::new(x, 1.0, 0.0)];
            Surface { shape: Shape::Triangle { corners }, material: 0, radiance: None, object: 7, has_corners: false }
        };
        (0..n).map(triangle).collect()
    }

    /// Whether all corners and balls are within some sphere.
    fn covers(targets: &[Target], surfaces: &[Surface]) -> bool {
        surfaces.iter().all(|surface| {
            targets.iter().any(|target| {
                let within = |point: DVec3, more: f64| {
                    point.distance(Vec3::from_array(target.centre).as_dvec3()) + more
                        <= f64::from(target.radius) * 1.000_001
                };
                match surface.shape {
                    Shape::Triangle { corners } => corners.iter().all(|&corner| within(corner, 0.0)),
                    Shape::Sphere { centre, radius } => within(centre, radius),
                    _ => false,
                }
            })
        })
    }

    #[test]
    fn balls_have_their_own_spheres_and_a_long_mesh_has_several() {
        let mut surfaces = vec![ball(-3.0), ball(-5.0)];
        surfaces.extend(strip(64));
        let found = targets(surfaces.iter());
        assert_eq!((found[0].centre, found[0].radius, found[1].centre), ([-3.0, 0.0, 0.0], 0.5, [-5.0, 0.0, 0.0]));
        assert!(covers(&found, &surfaces));
        let sections: f32 = found[2..].iter().map(|target| target.radius * target.radius).sum();
        // One sphere around all has 32².
        assert!(found.len() > 20 && sections < 100.0, "{} spheres of {sections}", found.len());
        assert!(!covers(&found[..found.len() - 1], &surfaces));
    }

    #[test]
    fn many_objects_share_spheres() {
        let surfaces: Vec<Surface> = (0..1000).map(|i| ball(f64::from(i) * 2.0)).collect();
        let found = targets(surfaces.iter());
        assert_eq!(found.len(), MOST);
        assert!(covers(&found, &surfaces));
    }

    #[test]
    fn a_light_aims_at_what_it_can_see() {
        let targets =
            [Target { centre: [0.0, -3.0, 0.0], radius: 1.0 }, Target { centre: [0.0, 3.0, 0.0], radius: 1.0 }];
        let down = Light { kind: LIGHT_AREA, normal: [0.0, -1.0, 0.0], ..Light::default() };
        let spot = Light {
            kind: LIGHT_SPOT,
            normal: [0.0, 1.0, 0.0],
            edges: [[0.0, 0.01, 0.0], [0.0; 3]],
            ..Light::default()
        };
        let near = Light { position: [0.0, 2.5, 0.0], ..down };
        let aside = Light { normal: [1.0, 0.0, 0.0], ..spot };
        let point = Light { kind: LIGHT_POINT, ..Light::default() };
        let mut lights = [down, spot, near, aside, point, near];
        let all = aim(&mut lights, &targets);
        let seen = lights.map(|light| {
            let first = light.first_target as usize;
            all[first..first + light.targets as usize].iter().map(|target| target.centre[1]).collect::<Vec<_>>()
        });
        assert_eq!(seen, [vec![-3.0], vec![3.0], vec![-3.0, 3.0], vec![], vec![-3.0, 3.0], vec![-3.0, 3.0]]);
        assert_eq!(all.len(), 4, "lights that see the same share a list");
    }
}
