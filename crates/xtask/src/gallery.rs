//! `cargo xtask gallery`: renders every built-in scene with the program, and makes a page of them.
//!
//! Times are kept by scene and device, so that runs on several machines make one page.

use crate::program::{Scenes, program, report};
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Most bytes of a picture: pictures are committed.
const MAX_BYTES: u64 = 100 << 10;
/// Widths that are tried, pixels, until a picture is small enough.
const WIDTHS: [u32; 4] = [320, 272, 224, 176];

/// What to render.
#[derive(clap::Args)]
pub struct Arguments {
    /// Where to render: auto, cpu, gpu, or gpu:NAME_OR_INDEX.
    #[arg(long, value_name = "D", default_value = "auto")]
    device: String,
    /// These scenes only; all built-in ones if not given.
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Only measures: pictures stay as they are.
    #[arg(long)]
    times: bool,
}

/// What is known of a scene's picture.
#[derive(Default, Serialize, Deserialize)]
struct Entry {
    description: String,
    /// The command that makes the picture.
    command: String,
    /// Seconds of that render, by device.
    seconds: BTreeMap<String, f64>,
}

/// Renders and writes `docs/gallery/` and `docs/GALLERY.md`.
pub fn run(arguments: &Arguments) -> Result<()> {
    let (root, program) = program()?;
    let folder = root.join("docs/gallery");
    fs::create_dir_all(&folder)?;
    let record = folder.join("gallery.json");
    let mut entries: BTreeMap<String, Entry> = match fs::read(&record) {
        Ok(bytes) => serde_json::from_slice(&bytes).with_context(|| format!("{} is damaged", record.display()))?,
        Err(_) => BTreeMap::new(),
    };
    let Scenes { listed, names, wanted } = Scenes::list(&program, &root, &arguments.scenes)?;
    // Scenes that are no longer there leave the page.
    entries.retain(|scene, _| names.contains(scene));
    for scene in &listed {
        let name = scene["name"].as_str().unwrap_or_default().to_string();
        if !wanted.contains(&name) {
            continue;
        }
        let entry = entries.entry(name.clone()).or_default();
        entry.description = scene["description"].as_str().unwrap_or_default().to_string();
        render(&program, &root, &name, arguments, entry)?;
        fs::write(&record, format!("{}\n", serde_json::to_string_pretty(&entries)?))?;
    }
    fs::write(root.join("docs/GALLERY.md"), page(&names, &entries))?;
    Ok(())
}

/// Renders a scene as large as fits and writes down how long it took.
fn render(program: &Path, root: &Path, name: &str, arguments: &Arguments, entry: &mut Entry) -> Result<()> {
    let picture = format!("docs/gallery/{name}.png");
    let path = root.join(&picture);
    for width in WIDTHS {
        let size = format!("{width}x{}", width * 3 / 4);
        let target =
            if arguments.times { std::env::temp_dir().join(format!("caustic-{name}.png")) } else { path.clone() };
        let target = target.display().to_string();
        let words = ["render", name, "--size", &size, "--spp", "64", "--tone-map", "agx"];
        let rest = ["-o", &target, "--device", &arguments.device, "--json", "--quiet"];
        let report = report(program, &[&words[..], &rest].concat(), root)?;
        let (Some(seconds), Some(device)) = (report["seconds"].as_f64(), report["device"].as_str()) else {
            bail!("the report of {name} lacks its time or its device");
        };
        let command = format!("caustic {} -o {name}.png", words.join(" "));
        if fs::metadata(&target)?.len() <= MAX_BYTES {
            if entry.command != command {
                // Times of another command are of another picture.
                entry.seconds.clear();
            }
            entry.command = command;
            entry.seconds.insert(device.to_string(), seconds);
            println!("{name}: {seconds:.2} s on {device}");
            return Ok(());
        }
    }
    bail!(
        "the picture of {name} has more than {MAX_BYTES} bytes even at a width of {} pixels",
        WIDTHS[WIDTHS.len() - 1]
    )
}

/// The page, in the order of `names`.
fn page(names: &[String], entries: &BTreeMap<String, Entry>) -> String {
    let mut page = String::from(
        "# Gallery\n\nEvery built-in scene, rendered by `cargo xtask gallery`: the command below each picture makes it again, bit for bit on any device. \
         Times are those of the whole render, s; `cargo xtask gallery --device D --times` adds those of another device.\n",
    );
    let known = || names.iter().filter_map(|name| Some((name, entries.get(name)?)));
    let devices: BTreeSet<&String> = known().flat_map(|(_, entry)| entry.seconds.keys()).collect();
    if !devices.is_empty() {
        let cells = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let head = std::iter::once("scene".to_string()).chain(devices.iter().map(ToString::to_string));
        let rule = std::iter::once("---").chain(devices.iter().map(|_| "--:")).map(ToString::to_string);
        let _ = write!(page, "\n{}{}", cells(head.collect()), cells(rule.collect()));
        for (name, entry) in known() {
            let of = |device: &&String| entry.seconds.get(*device).map_or("–".to_string(), |s| format!("{s:.2}"));
            page += &cells(std::iter::once(format!("[{name}](#{name})")).chain(devices.iter().map(of)).collect());
        }
    }
    for (name, entry) in known() {
        let _ = write!(page, "\n## {name}\n\n{}\n\n![{name}](gallery/{name}.png)\n\n", entry.description);
        let _ = write!(page, "```sh\n{}\n```\n", entry.command);
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_a_picture_a_command_and_times_in_the_order_of_the_list() {
        let entry = |seconds: &[(&str, f64)]| Entry {
            description: "A box".to_string(),
            command: "caustic render".to_string(),
            seconds: seconds.iter().map(|&(device, seconds)| (device.to_string(), seconds)).collect(),
        };
        let entries = BTreeMap::from([
            ("a".to_string(), entry(&[("CPU", 2.0), ("GPU", 0.25)])),
            ("b".to_string(), entry(&[("CPU", 1.5)])),
        ]);
        let page = page(&["b".to_string(), "a".to_string(), "new".to_string()], &entries);
        for part in [
            "![a](gallery/a.png)",
            "| scene | CPU | GPU |",
            "| [a](#a) | 2.00 | 0.25 |",
            "| [b](#b) | 1.50 | – |",
            "caustic render",
        ] {
            assert!(page.contains(part), "no `{part}` in {page}");
        }
        assert!(page.find("## b") < page.find("## a") && !page.contains("new"));
    }
}
