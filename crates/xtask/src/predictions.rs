//! `cargo xtask predictions`: what the planner foresees of every built-in scene, beside what comes.
//!
//! Figures are kept by device and scene, so that runs on several machines make one page.

use crate::program::{Scenes, program, report};
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Pixels of the pictures.
const SIZE: &str = "160x120";
/// What the planner is asked for.
const QUALITY: &str = "preview";
/// Passes of the references, which converge.
const PASSES: &str = "256";
/// Seeds whose pictures are compared: an error is foreseen as an expectation, and what rare bright samples do differs from seed to seed.
const SEEDS: [&str; 8] = ["1", "2", "3", "4", "5", "6", "7", "8"];

/// What to predict.
#[derive(clap::Args)]
pub struct Arguments {
    /// Where to render: auto, cpu, gpu, or gpu:NAME_OR_INDEX.
    #[arg(long, value_name = "D", default_value = "auto")]
    device: String,
    /// These scenes only; all built-in ones if not given.
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
}

/// What was foreseen, and what came.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Pair {
    foreseen: f64,
    came: f64,
}

impl Pair {
    fn ratio(self) -> f64 {
        self.foreseen / self.came
    }
}

/// A render.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Entry {
    /// What came is the median of all seeds.
    seconds: Pair,
    bytes: Pair,
    /// What came is the mean of all seeds.
    relmse: Pair,
    /// The least and the largest of the seeds.
    relmse_range: [f64; 2],
}

/// By device and scene.
type Entries = BTreeMap<String, BTreeMap<String, Entry>>;

/// Renders and writes `docs/predictions/`.
pub fn run(arguments: &Arguments) -> Result<()> {
    let (root, program) = program()?;
    let folder = root.join("docs/predictions");
    fs::create_dir_all(&folder)?;
    let record = folder.join("predictions.json");
    let mut entries: Entries = match fs::read(&record) {
        Ok(bytes) => serde_json::from_slice(&bytes).with_context(|| format!("{} is damaged", record.display()))?,
        Err(_) => Entries::new(),
    };
    let Scenes { names, wanted, .. } = Scenes::list(&program, &root, &arguments.scenes)?;
    for scene in &wanted {
        let (device, entry) = measure(&program, &root, scene, &arguments.device)?;
        println!("{scene}: {}", cells(&entry).join(", "));
        entries.entry(device).or_default().insert(scene.clone(), entry);
        fs::write(&record, format!("{}\n", serde_json::to_string_pretty(&entries)?))?;
    }
    fs::write(folder.join("README.md"), page(&names, &entries))?;
    Ok(())
}

/// Renders a scene as the planner chooses, and a reference.
fn measure(program: &Path, root: &Path, scene: &str, device: &str) -> Result<(String, Entry)> {
    let at = |name: &str| std::env::temp_dir().join(format!("caustic-{scene}-{name}.exr")).display().to_string();
    let (picture, reference) = (at("foreseen"), at("reference"));
    let render = |output: &str, rest: &[&str]| -> Result<Value> {
        let words = ["render", scene, "--size", SIZE, "--device", device, "-o", output, "--json", "--quiet"];
        report(program, &[&words[..], rest].concat(), root)
    };
    let passes = ["--integrator", "progressive", "--surface", "own", "--seed", "7", "--passes", PASSES];
    render(&reference, &[&passes[..], &["--spp", "4", "--photons", "50000", "--caustic-photons", "50000"]].concat())?;
    let number = |value: &Value, path: &str| -> Result<f64> {
        value.pointer(path).and_then(Value::as_f64).with_context(|| format!("the report of {scene} has no {path}"))
    };
    let (mut planned, mut seconds, mut errors) = (Value::Null, Vec::new(), Vec::new());
    for seed in SEEDS {
        // The survey does not depend on it, so that the same is foreseen, and chosen, for all.
        planned = render(&picture, &["--quality", QUALITY, "--seed", seed])?;
        seconds.push(number(&planned, "/seconds")?);
        let compared = report(program, &["compare", &picture, &reference, "--metric", "relmse", "--json"], root)?;
        errors.push(number(&compared, "/metrics/relmse/value")?);
    }
    errors.sort_by(f64::total_cmp);
    seconds.sort_by(f64::total_cmp);
    let foreseen = |name: &str| number(&planned, &format!("/plan/prediction/{name}"));
    let entry = Entry {
        seconds: Pair { foreseen: foreseen("seconds")?, came: seconds[SEEDS.len() / 2] },
        bytes: Pair { foreseen: foreseen("bytes")?, came: number(&planned, "/peak_bytes")? },
        relmse: Pair {
            foreseen: foreseen("noise")? + foreseen("bias")?,
            came: errors.iter().sum::<f64>() / errors.len() as f64,
        },
        relmse_range: [errors[0], errors[SEEDS.len() - 1]],
    };
    let device = planned["device"].as_str().context("the report has no device")?;
    Ok((device.to_string(), entry))
}

fn cells(entry: &Entry) -> [String; 7] {
    let Entry { seconds, bytes, relmse, relmse_range: [least, most] } = entry;
    let mib = f64::from(1 << 20);
    [
        format!("{:.2} / {:.2}", seconds.foreseen, seconds.came),
        format!("{:.2}", seconds.ratio()),
        format!("{:.1} / {:.1}", bytes.foreseen / mib, bytes.came / mib),
        format!("{:.2}", bytes.ratio()),
        format!("{:.1e} / {:.1e}", relmse.foreseen, relmse.came),
        format!("{:.2}", relmse.ratio()),
        format!("{least:.1e} to {most:.1e}"),
    ]
}

/// The page, with scenes in the order of `names`.
fn page(names: &[String], entries: &Entries) -> String {
    let mut page = format!(
        "# Predictions\n\nWhat `caustic render SCENE --size {SIZE} --quality {QUALITY}` foresees, and what comes: made by `cargo xtask predictions --device D`. \
         Time is the median and relMSE the mean of {} seeds, the latter against a progressive render of {PASSES} passes; rare bright samples are why seeds differ. The goal is a ratio of 0.75 to 1.25 in time, 0.9 to 1.1 in memory, and 0.67 to 1.5 in error.\n",
        SEEDS.len()
    );
    for (device, of_device) in entries {
        let within = |low: f64, high: f64, ratio: fn(&Entry) -> f64| {
            of_device.values().filter(|entry| (low..=high).contains(&ratio(entry))).count()
        };
        let _ = write!(
            page,
            "\n## {device}\n\nWithin the goal: {} of {} in time, {} in memory, {} in error.\n\n",
            within(0.75, 1.25, |entry| entry.seconds.ratio()),
            of_device.len(),
            within(0.9, 1.1, |entry| entry.bytes.ratio()),
            within(1.0 / 1.5, 1.5, |entry| entry.relmse.ratio())
        );
        page += "| scene | time, s: foreseen / came | ratio | memory, MiB | ratio | relMSE | ratio | seeds |\n| --- | --: | --: | --: | --: | --: | --: | --: |\n";
        for (name, entry) in names.iter().filter_map(|name| Some((name, of_device.get(name)?))) {
            let _ = writeln!(page, "| {name} | {} |", cells(entry).join(" | "));
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_counts_what_is_within_the_goal() {
        let entry = |ratio: f64| {
            let pair = Pair { foreseen: 2.0 * ratio, came: 2.0 };
            Entry { seconds: pair, bytes: pair, relmse: pair, relmse_range: [1.0, 3.0] }
        };
        let scenes = BTreeMap::from([("a".to_string(), entry(1.2)), ("b".to_string(), entry(1.05))]);
        let page = page(&["b".to_string(), "a".to_string()], &BTreeMap::from([("CPU".to_string(), scenes)]));
        assert!(page.contains("2 of 2 in time, 1 in memory, 2 in error"), "{page}");
        assert!(page.find("| b |") < page.find("| a |") && page.contains("| 2.40 / 2.00 | 1.20 |"), "{page}");
    }
}
