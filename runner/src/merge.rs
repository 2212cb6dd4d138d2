//! `caustic merge`.

use crate::Failure;
use crate::args::{LayerArgument, MergeArguments, layers};
use caustic_renderer::output::{self, Extras, Format, OutputError};
use caustic_renderer::{MergeError, join, merge};

/// Merges the parts of a render and writes the image, or a part.
pub fn run(arguments: &MergeArguments) -> Result<(), Failure> {
    if arguments.output.extension().is_some_and(|ending| ending == "caustic") {
        return part(arguments);
    }
    output::check_path(&arguments.output).map_err(Failure::input)?;
    let display = arguments.display.of(&arguments.output).map_err(Failure::input)?;
    let asked = layers(&arguments.aov);
    let exr = Format::of(&arguments.output) == Ok(Format::Exr);
    if let Some(layer) = asked.first().filter(|_| !exr) {
        let path = arguments.output.clone();
        return Err(Failure::input(OutputError::NoLayers { path, layer: layer.name() }));
    }
    let merged = merge(&arguments.parts).map_err(failure)?;
    let kinds = if arguments.aov.is_empty() || arguments.aov.contains(&LayerArgument::All) {
        merged.layers.clone()
    } else {
        asked
    };
    if let Some(layer) = kinds.iter().find(|kind| !merged.layers.contains(kind)) {
        let layer = layer.name();
        return Err(Failure::input(format!(
            "--aov {layer}: the parts were rendered without this layer; render them with --aov {layer}"
        )));
    }
    let layers = merged.layers_of(if exr { &kinds } else { &[] });
    let extras = Extras { display, layers: &layers };
    output::write_with(&arguments.output, &merged.image(), &merged.metadata, &extras).map_err(Failure::machine)?;
    if !arguments.quiet {
        let (parts, passes, photons) = (arguments.parts.len(), merged.state.passes(), merged.state.photons());
        let output = arguments.output.display();
        eprintln!("parts: {parts}, passes: {passes}, photons emitted: {photons}; wrote {output}");
        for note in merged.notes() {
            eprintln!("note: {note}");
        }
    }
    Ok(())
}

/// Merges parts into one.
fn part(arguments: &MergeArguments) -> Result<(), Failure> {
    let MergeArguments { parts, output, display, .. } = arguments;
    if !arguments.aov.is_empty() || display.exposure.is_some() || display.tone_map.is_some() {
        return Err(Failure::input(format!(
            "{} is a part and no picture yet: give --aov, --exposure and --tone-map where the picture is merged",
            output.display()
        )));
    }
    output::check_place(output).map_err(Failure::input)?;
    let joined = join(parts).map_err(failure)?;
    joined.write(output).map_err(Failure::machine)?;
    if !arguments.quiet {
        eprintln!("parts: {}; wrote {}, which is a part itself", parts.len(), output.display());
    }
    Ok(())
}

/// Whether an error is the input's or the machine's fault.
fn failure(error: MergeError) -> Failure {
    match error {
        MergeError::Read { .. } => Failure::machine(error),
        _ => Failure::input(error),
    }
}
