//! The command line.

mod bench;
mod cases;
mod compare;
mod experiments;
mod integrator;
mod map;
mod merge;
mod numbers;
mod photons;
mod picture;
mod plan;
mod tradeoff;

pub use bench::BenchArguments;
pub use cases::CasesArguments;
pub use compare::{CompareArguments, MetricArgument, Threshold};
pub use experiments::ExperimentsArguments;
pub use integrator::{IntegratorArguments, RadiusArgument};
pub use map::{EstimateArgument, MapArguments};
pub use merge::MergeArguments;
pub use photons::{DumpArgument, PhotonsArguments};
pub use picture::{DisplayArguments, LayerArgument, TonemapArguments, layers};
pub use plan::{CostsArgument, PlanArguments};
pub use tradeoff::TradeoffArguments;

use caustic_device::{DeviceChoice, DeviceChoices, Precision};
use caustic_photon_map::{Gather, Hash};
use caustic_renderer::Show;
use caustic_renderer::scene::limits::{MAX_K, MAX_PHOTONS, MAX_SPP};
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use numbers::{size, table, whole};
use std::path::PathBuf;

/// Photon mapping with one Rust source for CPU and GPU, the same bits on both.
#[derive(Parser)]
#[command(
    version,
    max_term_width = 110,
    after_help = "Without a command: caustic render cornell -o cornell.png\n\n\
        Examples:\n  \
        caustic render cornell -o box.exr --size 640x480 --spp 64\n  \
        caustic render cornell -o caustic.png --show map-caustic --caustic-photons 10000\n  \
        caustic render cornell -o box.exr --integrator progressive --surface own --time 60\n  \
        caustic render cornell -o box.exr --integrator path --spp 16 --passes 1000 --checkpoint box.state\n  \
        caustic render my_scene.toml -o picture.png --tone-map agx --device cpu\n  \
        caustic plan cornell --quality final\n  \
        caustic tradeoff cornell -o tradeoff --quick\n  \
        caustic photons cornell -o cornell.caustic\n  \
        caustic map --photons uniform:1000000 --queries 300000 --k 50\n  \
        caustic compare picture.png reference.png --metric flip --threshold 0.05 --diff error.png\n  \
        caustic verify --device gpu\n  \
        caustic bench --quick\n  \
        caustic bench --filter gather --json rows.json --svg plots\n  \
        caustic experiments --quick --only fig16,table3\n\n\
        Exit codes: 0 done, 1 the device or disk failed, 2 the input was wrong, 3 pictures differ by more than a threshold, \
        130 interrupted."
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Subcommand)]
pub enum Command {
    /// Renders a scene to a PNG, EXR or HDR file.
    Render(Box<RenderArguments>),
    /// Merges the parts of a render (`render --part I/N`) into the image that one process would have made.
    Merge(MergeArguments),
    /// Says what a render of a scene would model and why, and predicts its time, memory, noise and bias; takes the arguments of `render`.
    #[command(mut_arg("output", |output| output.required(false).hide(true)))]
    Plan(Box<RenderArguments>),
    /// Sweeps the settings of a scene and says which are worth having: time, memory and errors against a reference, and the Pareto front.
    Tradeoff(TradeoffArguments),
    /// Saves the photons of a scene for later renders, or tells of saved ones: statistics, CSV, point cloud.
    Photons(PhotonsArguments),
    /// Makes a PNG of a linear picture, with an exposure and a tone curve; or another linear format.
    Tonemap(TonemapArguments),
    /// Builds a photon map of given or synthetic photons, searches it, and checks the answers against brute force.
    Map(MapArguments),
    /// Says how much a PNG, EXR or HDR picture differs from a reference, and whether that is within a threshold.
    Compare(CompareArguments),
    /// Runs every kernel and small renders on a GPU and on the CPU with fresh random inputs, and compares them bit for bit.
    Verify(VerifyArguments),
    /// Measures sorts, photon maps, gathers, tracing and frames over many sizes, and checks every result.
    Bench(Box<BenchArguments>),
    /// Measures the experiments of the thesis again, and reports which of its claims hold.
    Experiments(ExperimentsArguments),
    /// Lists the devices: limits, subgroup sizes, and whether they can run the exact kernels.
    Info {
        /// Prints JSON instead of a table.
        #[arg(long)]
        json: bool,
    },
    /// About scenes.
    Scene {
        #[command(subcommand)]
        command: SceneCommand,
    },
    /// Writes a small scene with a comment at every field, to begin with.
    Init {
        /// The file.
        #[arg(value_name = "FILE", default_value = "scene.toml")]
        file: PathBuf,
    },
    /// Prints the completions of a shell, for example `caustic completions bash > ~/.local/share/bash-completion/completions/caustic`.
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Prints the manual page (`caustic man | man -l -`), or writes a page for each command.
    Man {
        /// Folder for the pages.
        #[arg(short, long, value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

impl Default for Command {
    fn default() -> Self {
        let words = ["caustic", "render", "cornell", "-o", "cornell.png"];
        match Arguments::parse_from(words).command {
            Some(command) => command,
            None => unreachable!("the default command names a command"),
        }
    }
}

#[derive(Subcommand)]
pub enum SceneCommand {
    /// Lists the built-in scenes, a line each.
    List {
        /// Prints JSON instead of a table.
        #[arg(long)]
        json: bool,
    },
    /// Prints the JSON schema of scene files, for editors.
    Schema {
        /// Prints the page that has every field instead, as Markdown.
        #[arg(long)]
        page: bool,
    },
    /// Says what a scene holds, and what in it may be wrong, each with a remedy.
    Check {
        /// A built-in scene, a scene file or a model (.ply, .obj, .gltf, .glb).
        scene: String,
        /// Prints JSON instead of text.
        #[arg(long)]
        json: bool,
    },
    /// Writes a scene as a .ply of triangles, or a scene file around a model as .toml.
    Convert {
        /// A built-in scene, a scene file or a model (.ply, .obj, .gltf, .glb).
        scene: String,
        /// The file to write: .toml or .ply.
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
    },
}

#[derive(Args)]
pub struct RenderArguments {
    /// A built-in scene (see `caustic scene list`) a scene file (docs/scene-format.md) or a model (.ply, .obj, .gltf, .glb).
    pub scene: String,
    /// The image: .png (sRGB, 8 bits), .exr (linear, 32-bit float, with the settings as metadata) or .hdr (linear, 8 bits and an exponent).
    #[arg(short, long, value_name = "FILE", required = true)]
    pub output: Option<PathBuf>,
    /// Size of the image in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub size: Option<[u32; 2]>,
    /// Photons emitted for the global map: more make indirect light less blotchy, for time and 32 bytes each stored.
    #[arg(long, value_name = "N", value_parser = whole(1, MAX_PHOTONS), allow_negative_numbers = true)]
    pub photons: Option<u32>,
    /// Photons emitted at mirrors and glass for the caustic map: more make caustics sharper.
    #[arg(long, value_name = "N", value_parser = whole(0, MAX_PHOTONS), allow_negative_numbers = true)]
    pub caustic_photons: Option<u32>,
    /// Takes the photons from a file of `caustic photons SCENE -o FILE` instead of tracing them: the image is the same.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["photons", "caustic_photons", "thin"])]
    pub load_map: Option<PathBuf>,
    /// Photons in an estimate: more are smoother and slower, fewer are sharper and noisier.
    #[arg(long, value_name = "K", value_parser = whole(1, MAX_K), allow_negative_numbers = true)]
    pub k: Option<u32>,
    /// Largest radius of an estimate in metres, reached only where photons are sparse; of a progressive render, the first radius. `auto`
    /// finds one from how densely photons lie where the camera looks.
    #[arg(long, value_name = "R|auto", value_parser = integrator::radius, allow_hyphen_values = true)]
    pub radius: Option<RadiusArgument>,
    /// Hash function of the photon maps: the image does not depend on it.
    #[arg(long, value_enum, default_value_t)]
    pub hash: HashArgument,
    /// Most entries of a map's table: fewer build faster, take less memory and are searched more slowly. The image does not depend on it.
    #[arg(long, value_name = "N", value_parser = table, allow_negative_numbers = true)]
    pub table: Option<u32>,
    /// How the nearest photons are found: the image does not depend on it.
    #[arg(long, value_enum, default_value_t)]
    pub gather: GatherArgument,
    /// Whether a GPU gives the CPU's bits, or is free to be faster.
    #[arg(long, value_enum, default_value_t)]
    pub precision: PrecisionArgument,
    /// Camera samples a pixel: more smooth edges, soft shadows and reflections.
    #[arg(long, value_name = "N", value_parser = whole(1, MAX_SPP), allow_negative_numbers = true)]
    pub spp: Option<u32>,
    /// Where to run: auto, cpu, gpu, gpu:NAME_OR_INDEX (see `caustic info`), gpu:all, or several such as gpu:0,gpu:1 or cpu+gpu:0. The image
    /// does not depend on it.
    #[arg(long, value_name = "D", default_value = "auto")]
    pub device: DeviceChoices,
    /// Seed of the random numbers: the same seed gives the same image on every device [default: 0, or that of --load-map].
    #[arg(long, value_name = "S", value_parser = whole(0, u32::MAX), allow_negative_numbers = true)]
    pub seed: Option<u32>,
    /// Which part of the light to show.
    #[arg(long, value_enum, default_value_t)]
    pub show: ShowArgument,
    #[command(flatten)]
    pub how: IntegratorArguments,
    #[command(flatten)]
    pub plan: PlanArguments,
    /// Layers of an EXR beside the picture; several with commas between them.
    #[arg(long, value_enum, value_name = "LAYERS", value_delimiter = ',')]
    pub aov: Vec<LayerArgument>,
    #[command(flatten)]
    pub display: DisplayArguments,
    /// Denoises the picture (not its layers) by OpenImageDenoise, if the program was built with the feature `denoise`: pleasant, biased, and not the
    /// same bits everywhere.
    #[arg(long)]
    pub denoise: bool,
    /// Ends with exit code 1, after the picture is written, if the report has a problem: power that the energy ledger cannot account for,
    /// numbers that are not finite, or paths that were given up.
    #[arg(long)]
    pub strict: bool,
    /// Prints nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Prints a machine-readable summary to standard output: times, photons, bytes, device.
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum HashArgument {
    /// Linear, unless its table is too small for how the photons crowd; then Teschner.
    #[default]
    Auto,
    /// Cell numbers: no collisions, a table as large as the grid.
    Linear,
    /// Teschner et al.: any extent of the scene.
    Teschner,
    /// Z-order: neighbouring cells lie near in memory.
    Morton,
}

impl From<HashArgument> for Hash {
    fn from(hash: HashArgument) -> Self {
        match hash {
            HashArgument::Auto => Self::Auto,
            HashArgument::Linear => Self::Linear,
            HashArgument::Teschner => Self::Teschner,
            HashArgument::Morton => Self::Morton,
        }
    }
}

#[derive(Args)]
pub struct VerifyArguments {
    /// The GPU: gpu, or gpu:NAME_OR_INDEX.
    #[arg(long, value_name = "DEVICE", default_value = "gpu")]
    pub device: DeviceChoice,
    /// Exact, or fast to see how far off that is.
    #[arg(long, value_enum, default_value_t)]
    pub precision: PrecisionArgument,
    /// Lets the GPU go on with its own results from this stage on (a name from the table), to find which stage matters.
    #[arg(long, value_name = "STAGE")]
    pub gpu_from: Option<String>,
    /// Seed of the random inputs; from the clock if not given.
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// Prints JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum PrecisionArgument {
    /// The same bits on every device.
    #[default]
    Exact,
    /// The GPU's driver may contract, and its own division, root and trigonometry are used; nothing changes on the CPU.
    Fast,
}

impl From<PrecisionArgument> for Precision {
    fn from(precision: PrecisionArgument) -> Self {
        match precision {
            PrecisionArgument::Exact => Self::Exact,
            PrecisionArgument::Fast => Self::Fast,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum GatherArgument {
    /// The heap; on a software GPU the histogram.
    #[default]
    Auto,
    /// Distances are counted, without a container.
    Histogram,
    /// A max-heap in a fixed-size array.
    Heap,
    /// The sorted list of the thesis.
    List,
}

impl From<GatherArgument> for Gather {
    fn from(gather: GatherArgument) -> Self {
        match gather {
            GatherArgument::Auto => Self::Auto,
            GatherArgument::Histogram => Self::Histogram,
            GatherArgument::Heap => Self::Heap,
            GatherArgument::List => Self::List,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub enum ShowArgument {
    /// All light.
    #[default]
    Beauty,
    /// Light seen straight from a light or after one diffuse reflection.
    Direct,
    /// Light that was diffusely reflected at least twice, from the global map.
    Global,
    /// Light that mirrors and glass throw on diffuse surfaces, from the caustic map.
    Caustic,
    /// The whole global map, visualised directly.
    MapGlobal,
    /// The whole caustic map, visualised directly.
    MapCaustic,
}

impl From<ShowArgument> for Show {
    fn from(show: ShowArgument) -> Self {
        match show {
            ShowArgument::Beauty => Self::Beauty,
            ShowArgument::Direct => Self::Direct,
            ShowArgument::Global => Self::Global,
            ShowArgument::Caustic => Self::Caustic,
            ShowArgument::MapGlobal => Self::MapGlobal,
            ShowArgument::MapCaustic => Self::MapCaustic,
        }
    }
}

#[cfg(test)]
mod tests;
