//! `caustic scene`: the built-in scenes, what a scene holds, and scenes as other files.

use crate::Failure;
use crate::args::SceneCommand;
use caustic_renderer::output;
use caustic_renderer::scene::{BUILT_IN, BuiltIn, ConvertTarget, Inspection, Scene};
use std::path::Path;

/// Runs one of its commands.
pub fn run(command: &SceneCommand) -> Result<(), Failure> {
    match command {
        SceneCommand::List { json } => list(*json),
        SceneCommand::Schema { page } => {
            print!("{}", if *page { Scene::reference() } else { Scene::schema() });
            Ok(())
        }
        SceneCommand::Check { scene, json } => check(scene, *json),
        SceneCommand::Convert { scene, output } => convert(scene, output),
    }
}

/// Lists the built-in scenes.
fn list(json: bool) -> Result<(), Failure> {
    if json {
        let line = |scene: &BuiltIn| serde_json::json!({ "name": scene.name, "description": scene.description() });
        println!("{:#}", serde_json::Value::from(BUILT_IN.iter().map(line).collect::<Vec<_>>()));
        return Ok(());
    }
    for scene in BUILT_IN {
        println!("{:<12} {}", scene.name, scene.description());
    }
    Ok(())
}

/// Says what a scene holds.
fn check(scene: &str, json: bool) -> Result<(), Failure> {
    let found = Scene::load(scene).map_err(Failure::input)?.inspect();
    if json {
        println!("{:#}", serde_json::to_value(&found).map_err(Failure::input)?);
        return Ok(());
    }
    let Inspection { quads, spheres, discs, triangles, smooth_triangles, materials, textures, lights, .. } = found;
    println!("{}", found.name);
    println!(
        "  surfaces   {quads} quads, {spheres} spheres, {discs} discs, {triangles} triangles ({smooth_triangles} with corners)"
    );
    println!("  looks      {materials} materials, {textures} textures, {lights} lights");
    if let Some(environment) = &found.environment {
        println!("  around it  {environment}");
    }
    println!("  extent     {:?} to {:?} m", found.low, found.high);
    println!("  memory     {:.1} MiB on a device", found.bytes as f64 / f64::from(1 << 20));
    let known: Vec<_> = found.kernels.iter().map(|feature| feature.title()).collect();
    println!(
        "  kernels    {}",
        if known.is_empty() { "basic".to_string() } else { format!("with {}", known.join(", ")) }
    );
    for note in &found.notes {
        println!("note: {note}");
    }
    for warning in &found.warnings {
        println!("warning: {warning}");
    }
    if found.warnings.is_empty() {
        println!("no warnings");
    }
    Ok(())
}

/// Writes a scene as another file.
fn convert(scene: &str, path: &Path) -> Result<(), Failure> {
    let target = ConvertTarget::of(path).map_err(Failure::input)?;
    let bytes = Scene::load(scene).and_then(|loaded| loaded.convert(scene, path, target)).map_err(Failure::input)?;
    output::check_place(path).map_err(Failure::input)?;
    output::replace(path, &bytes).map_err(Failure::machine)?;
    println!("wrote {}", path.display());
    Ok(())
}
