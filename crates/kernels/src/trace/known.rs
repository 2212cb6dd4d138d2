//! What a kernel knows of scenes: a mask of bits, of which those that a scene does not need are left out of the kernel that runs.
//!
//! A body takes its mask as a value of a type that is [`Known`]. On the CPU the masks nothing and everything are types of their own, [`Only`], so
//! that the compiler removes what they do not know, and the others are [`Told`]. An entry point of a GPU is told its mask by a
//! specialisation constant, which `device` writes into the SPIR-V before the driver compiles it. A mask that has a bit for all that a scene
//! holds gives the bits that [`EVERYTHING`] gives: whatever stands behind a bit has no effect where the scene has nothing for it.

/// Pictures on surfaces: colours, roughness, normals, emission and holes.
pub const TEXTURES: u32 = 1 << 0;
/// Materials of several lobes or of rough ones: metals, plastic, glTF's, rough glass.
pub const GLOSS: u32 = 1 << 1;
/// The insides of dielectrics: what they absorb, and that less is seen in them. Closed spheres of clear glass with nothing in them do without.
pub const MEDIA: u32 = 1 << 2;
/// Environments.
pub const SKY: u32 = 1 << 3;
/// Triangles and discs, normals at corners, and trees that have fewer lists than there are octants.
pub const MESHES: u32 = 1 << 4;
/// Spots, directional lights, and shining spheres, discs and triangles, beside quads and points.
pub const LAMPS: u32 = 1 << 5;
/// All of these.
pub const EVERYTHING: u32 = (1 << 6) - 1;

/// The mask of a kernel that knows everything.
pub const ALL: Only<EVERYTHING> = Only;

/// A mask of what a kernel knows.
pub trait Known: Copy {
    /// The mask.
    fn mask(self) -> u32;

    /// Whether it has [`TEXTURES`].
    #[inline]
    fn textures(self) -> bool {
        self.mask() & TEXTURES != 0
    }

    /// Whether it has [`GLOSS`].
    #[inline]
    fn gloss(self) -> bool {
        self.mask() & GLOSS != 0
    }

    /// Whether it has [`MEDIA`].
    #[inline]
    fn media(self) -> bool {
        self.mask() & MEDIA != 0
    }

    /// Whether it has [`SKY`].
    #[inline]
    fn sky(self) -> bool {
        self.mask() & SKY != 0
    }

    /// Whether it has [`MESHES`].
    #[inline]
    fn meshes(self) -> bool {
        self.mask() & MESHES != 0
    }

    /// Whether it has [`LAMPS`].
    #[inline]
    fn lamps(self) -> bool {
        self.mask() & LAMPS != 0
    }

    /// Whether a surface's shading normal may be another than its own: corners and pictures bend it.
    #[inline]
    fn bent(self) -> bool {
        self.mask() & (MESHES | TEXTURES) != 0
    }
}

/// A mask that the compiler knows.
#[derive(Clone, Copy)]
pub struct Only<const MASK: u32>;

impl<const MASK: u32> Known for Only<MASK> {
    #[inline]
    fn mask(self) -> u32 {
        MASK
    }
}

/// A mask that is told when the kernel runs or is loaded.
#[derive(Clone, Copy)]
pub struct Told(pub u32);

impl Known for Told {
    #[inline]
    fn mask(self) -> u32 {
        self.0
    }
}
