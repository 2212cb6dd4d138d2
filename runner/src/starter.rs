//! `caustic init`, `caustic completions` and `caustic man`: what a new user needs first.

use crate::Failure;
use crate::args::Arguments;
use caustic_renderer::output;
use clap::CommandFactory;
use clap_complete::Shell;
use std::io::{self, Write};
use std::path::Path;

/// The scene that `caustic init` writes.
const SCENE: &str = include_str!("starter.toml");

/// Writes a scene to begin with. A file that is there stays as it is.
pub fn init(path: &Path) -> Result<(), Failure> {
    if path.exists() {
        let message =
            format!("`{}` is there already; give a name that is free, such as `caustic init my.toml`", path.display());
        return Err(Failure::input(message));
    }
    if path.extension().is_none_or(|ending| ending != "toml") {
        let message = format!("`{}` does not end in .toml, as scenes do; call it `{0}.toml`", path.display());
        return Err(Failure::input(message));
    }
    output::check_place(path).map_err(Failure::input)?;
    output::replace(path, SCENE.as_bytes()).map_err(Failure::machine)?;
    let shown = path.display();
    eprintln!("wrote {shown}; render it with `caustic render {shown} -o {}`", path.with_extension("png").display());
    Ok(())
}

/// Prints the completions of a shell.
pub fn completions(shell: Shell) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "caustic", &mut text);
    print(&text)
}

/// Prints the manual, or writes a page for each command into a folder.
pub fn man(folder: Option<&Path>) -> Result<(), Failure> {
    let command = Arguments::command().name("caustic");
    match folder {
        Some(folder) => {
            output::check_place(&folder.join("caustic.1")).map_err(Failure::input)?;
            clap_mangen::generate_to(command, folder).map_err(Failure::machine)
        }
        None => {
            let mut text = Vec::new();
            clap_mangen::Man::new(command).render(&mut text).map_err(Failure::machine)?;
            print(&text)
        }
    }
}

fn print(text: &[u8]) -> Result<(), Failure> {
    match io::stdout().lock().write_all(text) {
        // Whoever reads has seen enough.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(Failure::machine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_renderer::scene::Scene;

    #[test]
    fn the_scene_to_begin_with_is_a_scene() {
        let scene = Scene::parse("scene.toml", SCENE).unwrap_or_else(|error| panic!("{error}"));
        assert!(scene.compile().has_specular, "it shows a caustic");
        let comments = SCENE.lines().filter(|line| line.contains('#')).count();
        assert!(comments > 15, "{comments} comments");
    }
}
