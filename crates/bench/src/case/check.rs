//! From a file's fields to a case: every field against its range, and none that the kind does not use.

use super::file::{CaseFile, GatherName, HashName, KindName};
use super::{Case, CaseError, Kind, MAX_N, Map, Target};
use caustic_photon_map::{Gather, Hash, MAX_K, RADII};
use caustic_renderer::scene::BUILT_IN as SCENES;
use caustic_renderer::scene::limits::{MAX_SIDE, MAX_SPP};
use std::collections::BTreeMap;

/// Bytes of a SHA-256 in hexadecimal.
const HEX: usize = 64;

struct Check<'a> {
    file: &'a str,
    text: &'a str,
}

impl Check<'_> {
    fn error(&self, field: &str, problem: impl AsRef<str>) -> CaseError {
        CaseError::field(self.file, self.text, field, problem.as_ref())
    }

    fn whole(&self, field: &str, value: i64, least: u32, most: u32) -> Result<u32, CaseError> {
        let value32 = u32::try_from(value).ok().filter(|value| (least..=most).contains(value));
        value32.ok_or_else(|| {
            self.error(field, format!("is {value} but must be a whole number from {least} to {most}; change it"))
        })
    }

    fn needed<T>(&self, field: &str, value: Option<T>, kind: &str) -> Result<T, CaseError> {
        value.ok_or_else(|| self.error(field, format!("is missing: a case of kind \"{kind}\" needs it")))
    }
}

/// Checks the fields of a file.
pub(super) fn check(file: &str, text: &str, fields: &CaseFile) -> Result<Case, CaseError> {
    let check = Check { file, text };
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if fields.name.is_empty() || fields.name.len() > 60 || !fields.name.chars().all(plain) {
        return Err(
            check.error("name", "must be 1 to 60 of the characters a-z, A-Z, 0-9, - and _: it names files, too")
        );
    }
    if fields.description.trim().is_empty() || fields.description.contains('\n') {
        return Err(check.error("description", "must be one line that says what the case measures"));
    }
    if fields.sizes.is_empty() {
        return Err(check.error("sizes", "is empty: give at least one N"));
    }
    let sizes: Result<Vec<u32>, _> = fields.sizes.iter().map(|&n| check.whole("sizes", n, 1, MAX_N)).collect();
    let sizes = sizes?;
    if !sizes.is_sorted_by(|a, b| a < b) {
        return Err(check.error("sizes", "must ascend, each N once"));
    }
    only_used(&check, fields)?;
    let kind = kind(&check, fields)?;
    for target in &fields.targets {
        check_target(&check, target, &sizes)?;
    }
    let expected = expected(&check, fields, &sizes)?;
    let (name, description) = (fields.name.clone(), fields.description.trim().to_string());
    Ok(Case { name, description, kind, sizes, targets: fields.targets.clone(), expected, path: None })
}

/// Refuses fields that the kind has no use for: they would be a misunderstanding.
fn only_used(check: &Check<'_>, fields: &CaseFile) -> Result<(), CaseError> {
    use KindName::{Build, Frame, Gather, Sort, Trace};
    let uses: [(&str, bool, &[KindName]); 12] = [
        ("output", fields.output.is_some(), &[Gather]),
        ("distribution", fields.distribution.is_some(), &[Build, Gather]),
        ("bits", fields.bits.is_some(), &[Sort]),
        ("pairs", fields.pairs.is_some(), &[Sort]),
        ("queries", fields.queries.is_some(), &[Gather]),
        ("k", fields.k.is_some(), &[Build, Gather, Frame]),
        ("radius", fields.radius.is_some(), &[Build, Gather]),
        ("hash", fields.hash.is_some(), &[Build, Gather]),
        ("gather", fields.gather.is_some(), &[Gather]),
        ("scene", fields.scene.is_some(), &[Trace, Frame]),
        ("size", fields.size.is_some(), &[Frame]),
        ("spp", fields.spp.is_some(), &[Frame]),
    ];
    for (field, given, kinds) in uses {
        if given && !kinds.contains(&fields.kind) {
            let kind = format!("{:?}", fields.kind).to_lowercase();
            return Err(check.error(field, format!("is not used by a case of kind \"{kind}\"; remove it")));
        }
    }
    Ok(())
}

fn kind(check: &Check<'_>, fields: &CaseFile) -> Result<Kind, CaseError> {
    Ok(match fields.kind {
        KindName::Sort => Kind::Sort {
            bits: check.whole("bits", check.needed("bits", fields.bits, "sort")?, 1, u32::BITS)?,
            pairs: fields.pairs.unwrap_or(true),
        },
        KindName::Build => Kind::Build(map(check, fields, "build")?),
        KindName::Gather => Kind::Gather {
            map: map(check, fields, "gather")?,
            queries: check.whole("queries", check.needed("queries", fields.queries, "gather")?, 1, MAX_N)?,
            output: fields.output.unwrap_or_default(),
            gather: gather(fields.gather.unwrap_or_default()),
        },
        KindName::Trace => Kind::Trace { scene: scene(check, fields, "trace")? },
        KindName::Frame => {
            let [width, height] = check.needed("size", fields.size, "frame")?;
            Kind::Frame {
                scene: scene(check, fields, "frame")?,
                size: [check.whole("size", width, 1, MAX_SIDE)?, check.whole("size", height, 1, MAX_SIDE)?],
                spp: check.whole("spp", fields.spp.unwrap_or(1), 1, MAX_SPP)?,
                k: check.whole("k", check.needed("k", fields.k, "frame")?, 1, MAX_K)?,
            }
        }
    })
}

fn map(check: &Check<'_>, fields: &CaseFile, kind: &str) -> Result<Map, CaseError> {
    let radius = fields.radius.map(|radius| radius as f32);
    if radius.is_some_and(|radius| !RADII.contains(&radius)) {
        return Err(check.error("radius", "must be a number of metres from 1e-9 to 1e18; leave it out for 2 k photons"));
    }
    Ok(Map {
        distribution: check.needed("distribution", fields.distribution, kind)?,
        k: check.whole("k", check.needed("k", fields.k, kind)?, 1, MAX_K)?,
        radius,
        hash: match fields.hash.unwrap_or_default() {
            HashName::Linear => Hash::Linear,
            HashName::Teschner => Hash::Teschner,
            HashName::Morton => Hash::Morton,
        },
    })
}

fn gather(name: GatherName) -> Gather {
    match name {
        GatherName::Auto => Gather::Auto,
        GatherName::Histogram => Gather::Histogram,
        GatherName::Heap => Gather::Heap,
        GatherName::List => Gather::List,
    }
}

fn scene(check: &Check<'_>, fields: &CaseFile, kind: &str) -> Result<String, CaseError> {
    let name = check.needed("scene", fields.scene.clone(), kind)?;
    if SCENES.iter().any(|scene| scene.name == name) {
        return Ok(name);
    }
    let known: Vec<_> = SCENES.iter().map(|scene| format!("\"{}\"", scene.name)).collect();
    Err(check.error("scene", format!("must be a built-in scene: {}", known.join(", "))))
}

fn check_target(check: &Check<'_>, target: &Target, sizes: &[u32]) -> Result<(), CaseError> {
    if !sizes.contains(&target.n) {
        return Err(
            check.error("targets", format!("is for N = {}, which is not among the sizes; add it there", target.n))
        );
    }
    if target.ms.is_none() && target.per_second.is_none() && target.faster_than.is_empty() {
        return Err(check.error("targets", "says nothing to reach: give `ms`, `per_second` or `faster_than`"));
    }
    let positive = |x: Option<f64>| x.is_none_or(|x| x > 0.0 && x.is_finite());
    if !positive(target.ms) || !positive(target.per_second) {
        return Err(check.error("targets", "must have a positive `ms` or `per_second`"));
    }
    Ok(())
}

fn expected(check: &Check<'_>, fields: &CaseFile, sizes: &[u32]) -> Result<BTreeMap<u32, String>, CaseError> {
    let mut expected = BTreeMap::new();
    for (n, hash) in &fields.expected {
        let Some(size) = n.parse().ok().filter(|n| sizes.contains(n)) else {
            return Err(check.error(n, "in [expected] is not among the sizes; remove it or add it there"));
        };
        if hash.len() != HEX || !hash.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b)) {
            return Err(
                check.error(n, format!("in [expected] must be a SHA-256: {HEX} digits 0-9a-f; --bless writes it"))
            );
        }
        expected.insert(size, hash.clone());
    }
    Ok(expected)
}
