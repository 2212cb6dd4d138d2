//! Scene files that somebody broke: millions of them end in a scene or in one clear sentence, never in a panic or a hang.
//!
//! `CAUSTIC_FUZZ=1000000` sets how many are tried; the default is what a test run has time for.

use caustic_kernels::num::pcg4d;
use caustic_renderer::Settings;
use caustic_renderer::scene::{BUILT_IN, Scene};
use std::panic::catch_unwind;

/// What the mutations insert: keys, values and punctuation of the format, and numbers at their ends.
const PIECES: [&str; 58] = [
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-1e999",
    "1e-999",
    "0",
    "-0",
    "-1",
    "1e9",
    "1e10",
    "1e-7",
    "4294967296",
    "9223372036854775808",
    "0x10",
    "1_000",
    "1.5",
    "\"",
    "'",
    "\"\"\"",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "=",
    ",",
    ".",
    "\n",
    "#",
    "\\",
    "\u{0}",
    "\u{feff}",
    "ü",
    "𝔘",
    "\r\n",
    "true",
    "[camera]\n",
    "[render]\n",
    "[[quads]]\n",
    "[[spheres]]\n",
    "[[lights]]\n",
    "[materials.x]\n",
    "position = [0, 0, 0]\n",
    "target = [0, 0, 0]\n",
    "up = [0, 0, 0]\n",
    "radius = 0\n",
    "ior = 0\n",
    "kind = \"glass\"\n",
    "material = \"white\"\n",
    "radiance = [1, 1, 1]\n",
    "reflectance = [2, 2, 2]\n",
    "edge_u = [0, 0, 0]\n",
    "spp = 0\n",
    "k = -3\n",
    "size = [0, 0]\n",
    "name = \"\\u001b[31m\"\n",
];

struct Random {
    seed: u32,
    step: u32,
}

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.step += 1;
        pcg4d([self.seed, self.step, 0xf022, 0])[0] as usize % n.max(1)
    }
}

/// One of the built-in scenes with one to eight changes.
fn broken(seed: u32) -> Vec<u8> {
    let mut random = Random { seed, step: 0 };
    let mut text = BUILT_IN[random.below(BUILT_IN.len())].text.as_bytes().to_vec();
    if random.below(2) == 0 {
        // A short file: changes meet where it matters more often.
        let from = random.below(text.len());
        text.drain(from..);
    }
    for _ in 0..=random.below(8) {
        let at = random.below(text.len() + 1);
        let end = (at + random.below(40)).min(text.len());
        match random.below(6) {
            0 => drop(text.splice(at..at, PIECES[random.below(PIECES.len())].bytes())),
            1 => drop(text.splice(at..end, PIECES[random.below(PIECES.len())].bytes())),
            2 => drop(text.drain(at..end)),
            3 => {
                let copy = text[at..end].to_vec();
                let to = random.below(text.len() + 1);
                text.splice(to..to, copy);
            }
            4 if at < text.len() => text[at] ^= 1 << random.below(8),
            _ => {
                // A number in place of another.
                let digits = text.iter().enumerate().filter(|(_, byte)| byte.is_ascii_digit()).map(|(i, _)| i);
                let digits: Vec<usize> = digits.collect();
                if !digits.is_empty() {
                    let digit = digits[random.below(digits.len())];
                    text.splice(digit..=digit, PIECES[random.below(17)].bytes());
                }
            }
        }
    }
    text
}

/// Reads a scene and everything that is made of it before the first photon.
fn read(bytes: &[u8]) -> Result<(), String> {
    let text = String::from_utf8_lossy(bytes);
    match Scene::parse("broken.toml", &text) {
        Ok(scene) => {
            let compiled = scene.compile();
            let floats =
                compiled.primitives.iter().flat_map(|p| p.position.into_iter().chain(p.normal).chain([p.size]));
            assert!(floats.chain(compiled.diffuse_bounds.0).chain(compiled.diffuse_bounds.1).all(f32::is_finite));
            assert!(compiled.lights.last().is_some_and(|light| light.cumulative == 1.0));
            let camera = scene.camera(64, 48);
            assert!(camera.corner.into_iter().chain(camera.right).chain(camera.down).all(f32::is_finite));
            Settings::of(&scene).validate().map_err(|error| error.to_string())
        }
        Err(error) => {
            let sentence = error.to_string();
            assert!(sentence.trim_start_matches('`').starts_with("broken.toml"), "the file is not named: {sentence}");
            assert!(!sentence.chars().any(char::is_control), "not one line of text: {sentence:?}");
            assert!(sentence.len() < 2000, "{} characters", sentence.len());
            Err(sentence)
        }
    }
}

fn count() -> u32 {
    std::env::var("CAUSTIC_FUZZ").ok().map_or(20_000, |count| count.parse().expect("CAUSTIC_FUZZ is a number"))
}

#[test]
fn a_broken_scene_file_is_a_sentence() {
    let (mut scenes, mut sentences) = (0, std::collections::BTreeSet::new());
    for seed in 0..count() {
        let bytes = broken(seed);
        match catch_unwind(|| read(&bytes)) {
            Ok(Ok(())) => scenes += 1,
            Ok(Err(sentence)) => {
                let words: Vec<&str> =
                    sentence.split_whitespace().filter(|word| word.chars().all(char::is_alphabetic)).collect();
                sentences.insert(words.join(" "));
            }
            Err(_) => panic!("seed {seed} panicked on this file:\n{}", String::from_utf8_lossy(&bytes)),
        }
    }
    println!("{} files: {scenes} were scenes still, {} kinds of sentences", count(), sentences.len());
    assert!(scenes > 100 && sentences.len() > 50, "{scenes} scenes, {} kinds of sentences", sentences.len());
}
