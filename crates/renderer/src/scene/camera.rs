//! From a viewpoint to the kernels' camera.

use super::content::Viewpoint;
use caustic_kernels::trace::Camera;
use glam::DVec3;

/// The camera for a picture of `width` × `height` pixels.
pub(super) fn camera(view: &Viewpoint, width: u32, height: u32) -> Camera {
    let forward = (view.target - view.position).normalize();
    let right = forward.cross(view.up).normalize();
    let up = right.cross(forward);
    let (columns, rows) = (f64::from(width.max(1)), f64::from(height.max(1)));
    // Half the film's sides, at distance 1.
    let half_height = (view.vertical_fov_degrees.to_radians() / 2.0).tan();
    let half_width = half_height * columns / rows;
    let rounded = |v: DVec3| v.as_vec3().to_array();
    Camera {
        origin: rounded(view.position),
        width,
        corner: rounded(forward - right * half_width + up * half_height),
        height,
        right: rounded(right * (2.0 * half_width / columns)),
        down: rounded(up * (-2.0 * half_height / rows)),
        lens: [rounded(right * view.lens_radius), rounded(up * view.lens_radius)],
        focus: if view.lens_radius > 0.0 { view.focus as f32 } else { 0.0 },
        jitter: 1.0,
    }
}
