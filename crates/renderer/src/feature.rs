//! What a render models, and what it leaves out because the scene does not need it. Whatever is left out has no light to add: forcing it
//! gives the same bits.

use crate::scene::CompiledScene;
use crate::scene::bvh::FEW;
use crate::{Settings, Show};
use caustic_kernels::trace::known::{GLOSS, LAMPS, MEDIA, MESHES, SKY, TEXTURES};
use caustic_kernels::trace::{PART_CAUSTIC, PART_GLOBAL, RAY_CAUSTIC};
use serde::Serialize;

/// What can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feature {
    /// The map of light that comes to diffuse surfaces through mirrors and glass.
    CausticMap,
    /// The map of light that was diffusely reflected before.
    GlobalMap,
    /// A tree over the surfaces instead of a list.
    Tree,
    /// Pictures on surfaces, in kernels.
    Textures,
    /// Rough lobes and coats, in kernels.
    Gloss,
    /// The insides of dielectrics, in kernels.
    Media,
    /// An environment, in kernels.
    Sky,
    /// Triangles and discs, in kernels.
    Meshes,
    /// Lights that are neither quads nor points, in kernels.
    Lamps,
}

impl Feature {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::CausticMap,
        Self::GlobalMap,
        Self::Tree,
        Self::Textures,
        Self::Gloss,
        Self::Media,
        Self::Sky,
        Self::Meshes,
        Self::Lamps,
    ];

    /// What it is called in sentences.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::CausticMap => "caustic map",
            Self::GlobalMap => "global map",
            Self::Tree => "tree",
            Self::Textures => "textures",
            Self::Gloss => "gloss",
            Self::Media => "media",
            Self::Sky => "sky",
            Self::Meshes => "meshes",
            Self::Lamps => "lamps",
        }
    }

    /// Its bit in the mask of what kernels [know](caustic_kernels::trace::known); 0 of what is decided outside of kernels.
    #[must_use]
    pub fn bit(self) -> u32 {
        match self {
            Self::CausticMap | Self::GlobalMap | Self::Tree => 0,
            Self::Textures => TEXTURES,
            Self::Gloss => GLOSS,
            Self::Media => MEDIA,
            Self::Sky => SKY,
            Self::Meshes => MESHES,
            Self::Lamps => LAMPS,
        }
    }
}

/// Whether a feature is modelled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Decision {
    /// The feature.
    pub feature: Feature,
    /// Whether it is modelled.
    pub modelled: bool,
    /// Whether it is so only because the settings force it.
    pub forced: bool,
    /// Why, in part of a sentence.
    pub why: String,
}

/// Decides on all features, in the order of [`Feature::ALL`]. `scene` is compiled with [`Settings::forced`].
#[must_use]
pub fn decide(scene: &CompiledScene, settings: &Settings) -> [Decision; 9] {
    Feature::ALL.map(|feature| {
        let (asked, needed, why) = match feature {
            Feature::CausticMap => caustic_map(scene, settings),
            Feature::GlobalMap => global_map(scene, settings),
            Feature::Tree => tree(scene),
            _ => knowledge(scene, feature),
        };
        let forced = asked && !needed && settings.forced.contains(&feature);
        Decision { feature, modelled: asked && (needed || forced), forced, why }
    })
}

/// Whether it is asked for, whether the scene needs it, and why.
fn caustic_map(scene: &CompiledScene, settings: &Settings) -> (bool, bool, String) {
    let aimed = scene.fewest_photons(RAY_CAUSTIC) > 0;
    let (asked, why) = if settings.parts() & PART_CAUSTIC == 0 {
        (false, "the picture does not ask for it")
    } else if settings.caustic_photons == 0 {
        (false, "it is given no photons")
    } else if !scene.has_specular {
        (aimed, "nothing in the scene is specular")
    } else if !aimed {
        (false, "no light can face a specular surface")
    } else {
        (true, "lights can face specular surfaces")
    };
    (asked, scene.has_specular, why.to_string())
}

fn global_map(scene: &CompiledScene, settings: &Settings) -> (bool, bool, String) {
    let asked = settings.parts() & PART_GLOBAL != 0;
    // Who asks for the map alone, or looks at it from elsewhere, also wants the light that comes straight from lights.
    let whole = settings.show != Show::Beauty || settings.final_gather > 0;
    let why = if !asked {
        "the picture does not ask for it"
    } else if scene.interreflects {
        "surfaces that reflect see each other"
    } else if whole {
        "it is to be shown or gathered from"
    } else {
        "all that reflects is matt and lies in one plane, so that no light is reflected twice"
    };
    (asked, scene.interreflects || whole, why.to_string())
}

fn tree(scene: &CompiledScene) -> (bool, bool, String) {
    let surfaces = scene.info.primitives as usize;
    let needed = surfaces > FEW;
    let why = if needed {
        format!("{surfaces} surfaces are more than the {FEW} that are faster in a list")
    } else {
        format!("{surfaces} surfaces are no more than the {FEW} that are faster in a list")
    };
    (true, needed, why)
}

/// Whether kernels know it.
fn knowledge(scene: &CompiledScene, feature: Feature) -> (bool, bool, String) {
    let (there, not) = match feature {
        Feature::Textures => ("surfaces have pictures", "no surface has a picture"),
        Feature::Gloss => ("there are rough lobes or coats", "all is matt, a mirror or smooth glass"),
        Feature::Media => (
            "there is glass that absorbs, is no closed sphere, or has something in it",
            "there is no glass but clear closed spheres with nothing in them",
        ),
        Feature::Sky => ("there is an environment", "there is no environment"),
        Feature::Meshes => {
            ("there are triangles or discs, or too many surfaces for eight lists", "all surfaces are quads and spheres")
        }
        _ => ("there are lights that are neither quads nor points", "all lights are quads and points"),
    };
    let needed = scene.needs & feature.bit() != 0;
    (true, needed, if needed { there } else { not }.to_string())
}
