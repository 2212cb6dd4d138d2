//! Layers of a picture: what it is made of, beside the picture itself.

use caustic_kernels::trace::LayerPixel;

/// What a layer tells of each pixel.
///
/// [`Direct`](Self::Direct), [`Global`](Self::Global) and [`Caustic`](Self::Caustic) add up to the picture of one pass, (direct +
/// global) + caustic in f32, bit for bit. The layers from [`Radius`](Self::Radius) to [`Depth`](Self::Depth) are means of the samples that see a diffuse surface, through
/// mirrors and glass if need be, and 0 where none does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LayerKind {
    /// Light that is seen straight or came straight from a light, W·sr⁻¹·m⁻².
    Direct,
    /// Light from the global map, W·sr⁻¹·m⁻².
    Global,
    /// Light from the caustic map, W·sr⁻¹·m⁻².
    Caustic,
    /// Radius of the estimates from the global and the caustic map, m.
    Radius,
    /// Photons in the estimates from the global and the caustic map.
    Photons,
    /// Normal of the side that is seen, in the scene's coordinates; shorter than 1 where samples differ.
    Normal,
    /// Reflectance of the surface, times what mirrors and glass on the way let through.
    Albedo,
    /// Length of the path from the camera to the surface, m.
    Depth,
    /// Variance of the picture, (W·sr⁻¹·m⁻²)², from how its passes differ.
    Variance,
    /// Estimate of the picture's bias, W·sr⁻¹·m⁻², from estimates over the whole and over half of each disc: below 0 where the picture is
    /// too dark. Its own standard deviation is twice the picture's part that comes from maps.
    Bias,
}

impl LayerKind {
    /// Those that a photon-mapped picture has.
    pub const OF_PHOTON_MAPS: [Self; 9] = [
        Self::Direct,
        Self::Global,
        Self::Caustic,
        Self::Radius,
        Self::Photons,
        Self::Normal,
        Self::Albedo,
        Self::Depth,
        Self::Bias,
    ];

    /// Its name, in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Global => "global",
            Self::Caustic => "caustic",
            Self::Radius => "radius",
            Self::Photons => "photons",
            Self::Normal => "normal",
            Self::Albedo => "albedo",
            Self::Depth => "depth",
            Self::Variance => "variance",
            Self::Bias => "bias",
        }
    }

    /// Names of its channels: `direct.R` and so on, as OpenEXR has layers (Kainz and Bogart, "Technical Introduction to OpenEXR").
    #[must_use]
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Direct | Self::Global | Self::Caustic | Self::Albedo | Self::Variance | Self::Bias => {
                &["R", "G", "B"]
            }
            Self::Normal => &["X", "Y", "Z"],
            Self::Radius | Self::Photons => &["global", "caustic"],
            Self::Depth => &["Z"],
        }
    }
}

/// A layer: for each pixel, row by row from the top left, as many floats as it has channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// What it tells.
    pub kind: LayerKind,
    /// The floats: those of a pixel one after another, in the order of [`LayerKind::channels`].
    pub values: Vec<f32>,
}

impl Layer {
    /// The layer of this kind of pixels that a device developed; none of what is no part of [`LayerPixel`].
    #[must_use]
    pub(crate) fn of(kind: LayerKind, pixels: &[LayerPixel]) -> Self {
        fn all<const N: usize>(pixels: &[LayerPixel], of: impl Fn(&LayerPixel) -> [f32; N]) -> Vec<f32> {
            pixels.iter().flat_map(of).collect()
        }
        let values = match kind {
            LayerKind::Direct => all(pixels, |pixel| pixel.direct),
            LayerKind::Global => all(pixels, |pixel| pixel.global),
            LayerKind::Caustic => all(pixels, |pixel| pixel.caustic),
            LayerKind::Radius => all(pixels, |pixel| pixel.radius),
            LayerKind::Photons => all(pixels, |pixel| pixel.photons),
            LayerKind::Normal => all(pixels, |pixel| pixel.normal),
            LayerKind::Albedo => all(pixels, |pixel| pixel.albedo),
            LayerKind::Depth => all(pixels, |pixel| [pixel.depth]),
            LayerKind::Bias => all(pixels, |pixel| pixel.bias),
            LayerKind::Variance => Vec::new(),
        };
        Self { kind, values }
    }
}
