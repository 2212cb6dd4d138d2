//! The two sets of modules.

/// What a set's float operations may give.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Arithmetic {
    /// The same bits on every device.
    Exact,
    /// What the driver likes: it may contract, and its own division, root, sine and cosine are used. Without NaN and
    /// infinite constants, so that wgpu's portable path takes the modules as well.
    Fast,
}

impl Arithmetic {
    /// Both sets.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Fast];

    /// How messages call the set.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Fast => "fast",
        }
    }

    /// The subfolder of the set's modules, with the slash after it.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Exact => "",
            Self::Fast => "fast/",
        }
    }

    /// The file of a kernel's module.
    pub fn file(self, kernel: &str) -> String {
        format!("{}{kernel}.spv", self.folder())
    }

    /// Features of `shaders-crate` that give the set.
    pub fn features(self) -> &'static [&'static str] {
        match self {
            Self::Exact => &[],
            Self::Fast => &["fast"],
        }
    }
}
