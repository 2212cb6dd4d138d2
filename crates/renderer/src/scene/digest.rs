//! What photons depend on, in 32 bytes.

use super::CompiledScene;
use sha2::{Digest, Sha256};

impl CompiledScene {
    /// SHA-256 of everything that photons depend on, as hexadecimal digits: surfaces, materials and lights, not the camera.
    ///
    /// The tree over the surfaces is left out: no hit depends on how it is built.
    #[must_use]
    pub fn sha256(&self) -> String {
        // A field that is added is missing here, until it is decided whether photons depend on it.
        let Self {
            info,
            nodes: _,
            primitives,
            materials,
            lights,
            targets,
            corners,
            textures,
            texels,
            needs: _,
            known: _,
            interreflects: _,
            diffuse_bounds: _,
            has_specular: _,
            has_diffuse: _,
            emitted_power_w: _,
        } = self;
        let mut digest = Sha256::new();
        digest.update(bytemuck::bytes_of(info));
        digest.update(bytemuck::cast_slice::<_, u8>(primitives));
        digest.update(bytemuck::cast_slice::<_, u8>(materials));
        digest.update(bytemuck::cast_slice::<_, u8>(lights));
        digest.update(bytemuck::cast_slice::<_, u8>(targets));
        digest.update(bytemuck::cast_slice::<_, u8>(corners));
        digest.update(bytemuck::cast_slice::<_, u8>(textures));
        digest.update(bytemuck::cast_slice::<_, u8>(texels));
        hex(&digest.finalize())
    }
}

/// Bytes as hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |text, byte| format!("{text}{byte:02x}"))
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    #[test]
    fn another_material_is_another_scene_and_another_camera_is_not() {
        let cornell = crate::scene::BUILT_IN[0].text;
        let digest = |text: &str| Scene::parse("a", text).unwrap().compile().sha256();
        let same = cornell.replace("vertical_fov_degrees = ", "vertical_fov_degrees = 1");
        assert_ne!(same, cornell);
        assert_eq!(digest(cornell), digest(&same));
        let other = cornell.replacen("reflectance = [0.", "reflectance = [0.1", 1);
        assert_ne!(other, cornell);
        assert_ne!(digest(cornell), digest(&other));
    }
}
