//! Writes stages of the thesis's experiments with their inputs and the recorder's counts into a folder, so that they can be run
//! elsewhere: `tests/reference/profiler` does so under a GPU's profiler.

use caustic_bench::Digest;
use caustic_device::{Access, Device, Kernel, Observed, Observer};
use caustic_photon_map::{Gather, Hash};
use caustic_recorder::Recorder;
use caustic_renderer::scene::Scene;
use caustic_renderer::{Show, View, trace_photons};
use caustic_rivals::{BruteSort, Cells, KdSearch, Photons, Technique};
use serde_json::{Value, json};
use std::error::Error;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

const PHOTONS: usize = 100_000;
const SIZE: [u32; 2] = [320, 240];
const K: u32 = 50;
const RADIUS: f32 = 0.074;
/// Larger inputs are left out: they would have to be carried.
const MOST_BYTES: usize = 8 << 20;

const TECHNIQUES: &[(&str, Technique)] = &[
    ("linear", Technique::hash(Hash::Linear, Cells::CentreFirst, Gather::List)),
    ("linear", Technique::hash(Hash::Linear, Cells::CentreFirst, Gather::Heap)),
    ("teschner", Technique::hash(Hash::Teschner, Cells::CentreFirst, Gather::List)),
    ("teschner", Technique::hash(Hash::Teschner, Cells::CentreFirst, Gather::Heap)),
    ("caustic", Technique::hash(Hash::Linear, Cells::Crowding, Gather::Histogram)),
    ("caustic", Technique::hash(Hash::Linear, Cells::Crowding, Gather::Heap)),
    ("caustic-teschner", Technique::hash(Hash::Teschner, Cells::Crowding, Gather::Histogram)),
    ("caustic-teschner", Technique::hash(Hash::Teschner, Cells::Crowding, Gather::Heap)),
    ("caustic-morton", Technique::hash(Hash::Morton, Cells::Crowding, Gather::Histogram)),
    ("cells", Technique::Cells { hash: Hash::Linear }),
    ("jensen", Technique::Jensen),
    ("kd", Technique::KdTree { search: KdSearch::Range }),
    ("kd", Technique::KdTree { search: KdSearch::Nearest }),
    ("brute", Technique::Brute { sort: BruteSort::Insertion }),
];

/// Writes down each kernel of a technique once.
struct Writer {
    folder: PathBuf,
    technique: Mutex<&'static str>,
    stages: Mutex<Vec<Value>>,
}

impl Writer {
    fn stage(&self, stage: &Observed<'_>, name: &str) -> Value {
        let recorder = Recorder::new(32);
        recorder.observe(stage);
        let buffers = stage.kernel.bindings().iter().zip(stage.buffers).map(|(binding, words)| {
            let mut digest = Digest::default();
            digest.add(words);
            // What a kernel writes is for comparison, and its beginning is enough.
            let kept = if binding.access.writes() { &words[..words.len().min(1 << 14)] } else { words };
            let file = &digest.hex()[..16];
            std::fs::write(self.folder.join(file), bytemuck::cast_slice::<u32, u8>(kept)).unwrap();
            json!({ "access": format!("{:?}", binding.access), "bytes": 4 * words.len(), "file": file })
        });
        json!({
            "technique": name,
            "kernel": stage.kernel.entry_point(),
            "lanes": stage.kernel.lanes(),
            "groups": stage.groups,
            "buffers": buffers.collect::<Vec<_>>(),
            "recorder": recorder.report()[0],
        })
    }
}

impl Observer for Writer {
    fn observe(&self, stage: &Observed<'_>) {
        let bindings = || stage.kernel.bindings().iter().zip(stage.buffers);
        // Its translation hangs.
        let hangs = stage.kernel == Kernel::CellBegins;
        let changes = bindings().any(|(binding, _)| binding.access == Access::InOut);
        let large = bindings().any(|(binding, words)| !binding.access.writes() && 4 * words.len() > MOST_BYTES);
        // Ballots cannot be translated; the sort without them does the same with the same buffers.
        let kernel = match stage.kernel {
            Kernel::RadixCount => Kernel::RadixCountPlain,
            Kernel::RadixScatter => Kernel::RadixScatterPlain,
            kernel => kernel,
        };
        let stage = &Observed { kernel, ..*stage };
        let name = *self.technique.lock().unwrap();
        let mut stages = self.stages.lock().unwrap();
        let kernel = stage.kernel.entry_point();
        // Techniques share what prepares a search.
        let is_there =
            |row: &Value| row["kernel"] == kernel && (row["technique"] == name || !kernel.starts_with("neighbours"));
        if !hangs && !changes && !large && !stages.iter().any(is_there) {
            let row = self.stage(stage, name);
            stages.push(row);
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("name a folder to write into")?);
    std::fs::create_dir_all(&folder)?;
    let cpu = Device::cpu();
    let scene = Scene::load("cornell")?;
    let mut photons = trace_photons(&cpu, &scene, Show::MapGlobal, 400_000, 0)?;
    assert!(photons.len() >= PHOTONS, "{} photons", photons.len());
    photons.truncate(PHOTONS);
    let view = View::new(&cpu, &scene, SIZE, 1, 0)?;
    let queries: Vec<caustic_kernels::layout::Query> = cpu.read(&view.queries, u64::from(view.count()))?;

    let writer = Arc::new(Writer { folder, technique: Mutex::new(""), stages: Mutex::default() });
    let device = Device::observed(writer.clone());
    let photons = Photons::upload(&device, &photons)?;
    let queries = device.upload("queries", &queries)?;
    for &(name, technique) in TECHNIQUES {
        *writer.technique.lock().unwrap() = name;
        let index = technique.build(&device, &photons, RADIUS)?;
        // Brute force has the same stages for each chunk of queries.
        let count = if name == "brute" { 32 } else { view.count() };
        index.search(&device, &queries, count, K)?;
    }
    let stages = writer.stages.lock().unwrap();
    std::fs::write(writer.folder.join("stages.json"), format!("{:#}\n", Value::from(stages.clone())))?;
    let lines: String = stages.iter().map(line).collect();
    std::fs::write(writer.folder.join("stages.txt"), lines)?;
    println!("{} stages", stages.len());
    Ok(())
}

/// A stage in a line, for a program that reads no JSON.
fn line(stage: &Value) -> String {
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_string);
    let buffers = stage["buffers"].as_array().into_iter().flatten();
    let words = ["technique", "kernel", "lanes", "groups"].map(|name| text(&stage[name]));
    let buffers = buffers.flat_map(|buffer| ["access", "bytes", "file"].map(|name| text(&buffer[name])));
    words.into_iter().chain(buffers).collect::<Vec<_>>().join(" ") + "\n"
}
