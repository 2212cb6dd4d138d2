//! `caustic tonemap`.

use crate::Failure;
use crate::args::TonemapArguments;
use caustic_renderer::output::{self, Extras, Format, Metadata};

/// Writes a picture in another format. What an EXR says about how it was made is lost, and its layers are.
pub fn run(arguments: &TonemapArguments) -> Result<(), Failure> {
    let TonemapArguments { input, output, display } = arguments;
    output::check_path(output).map_err(Failure::input)?;
    let display = display.of(output).map_err(Failure::input)?;
    let image = output::read(input).map_err(Failure::input)?;
    if Format::of(output).map_err(Failure::input)? == Format::Png {
        // Codes show neither: both would be black without a word.
        let odd = image.rgb.iter().flatten().filter(|value| value.is_nan()).count();
        if odd > 0 {
            eprintln!("note: {odd} values of {} are not numbers and become black", input.display());
        }
    }
    let extras = Extras { display, ..Extras::default() };
    output::write_with(output, &image, &Metadata::default(), &extras).map_err(Failure::machine)
}
