//! The most of everything that a scene file may ask for.

/// Most bytes of a scene file.
pub const MAX_FILE_BYTES: u64 = 16 << 20;
/// Most surfaces a scene may have, triangles included: their records and their tree take 512 MiB then, and the normals and texture
/// coordinates of triangles 144 MiB.
pub const MAX_SURFACES: usize = 1 << 22;
/// Most lights a scene may have, so that the weakest is still drawn now and then.
pub const MAX_LIGHTS: usize = 4096;
/// Most pixels along one side of a picture.
pub const MAX_SIDE: u32 = 65_536;
/// Most photons that a pass may emit by a scene's defaults.
pub const MAX_PHOTONS: u32 = 1 << 29;
/// Most photons that a scene's defaults may ask for in an estimate.
pub const MAX_K: u32 = caustic_photon_map::MAX_K;
/// Most samples a pixel that a scene's defaults may ask for.
pub const MAX_SPP: u32 = 65_536;
