//! Reads the finished words, and nothing that led to them, for what must hold.

use crate::postprocess::is_float_arithmetic;
use anyhow::{Context, Result, bail};
use rspirv::spirv::{Decoration, Op};
use std::collections::BTreeSet;
use std::io::Write;
use std::process::{Command, Stdio};

/// Fails if a float operation lacks `NoContraction`, reading the finished words and nothing else.
pub fn no_contraction(words: &[u32]) -> Result<()> {
    let pinned: BTreeSet<u32> = instructions(words)?
        .into_iter()
        .filter(|(op, operands)| {
            *op == Op::Decorate as u32 && operands.get(1) == Some(&(Decoration::NoContraction as u32))
        })
        .map(|(_, operands)| operands[0])
        .collect();
    let bare: Vec<u32> = float_ops(words)?.into_iter().filter(|id| !pinned.contains(id)).collect();
    match bare.first() {
        Some(first) => bail!("{} float operations lack NoContraction, the first is %{first}", bare.len()),
        None => Ok(()),
    }
}

/// Result ids of the float operations in `words`.
pub fn float_ops(words: &[u32]) -> Result<Vec<u32>> {
    let is_float = |op: u32| Op::from_u32(op).is_some_and(is_float_arithmetic);
    Ok(instructions(words)?.into_iter().filter(|(op, _)| is_float(*op)).map(|(_, operands)| operands[1]).collect())
}

/// Opcodes and the words after them: five words of header, then each instruction with its length in the upper half.
fn instructions(words: &[u32]) -> Result<Vec<(u32, &[u32])>> {
    let mut rest = words.get(5..).unwrap_or_default();
    let mut found = Vec::new();
    while let Some(&first) = rest.first() {
        let length = (first >> 16) as usize;
        if length == 0 || length > rest.len() {
            bail!("the SPIR-V is cut off in an instruction");
        }
        found.push((first & 0xffff, &rest[1..length]));
        rest = &rest[length..];
    }
    Ok(found)
}

/// Fails if the words hold one of the `private` paths.
pub fn no_paths(words: &[u32], private: &[String]) -> Result<()> {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let found = private.iter().find(|path| bytes.windows(path.len()).any(|window| window == path.as_bytes()));
    match found {
        Some(path) => bail!("the SPIR-V still holds the path {path}"),
        None => Ok(()),
    }
}

/// Has spirv-val read the module, where there is one; returns what to say about it.
pub fn spirv_val(bytes: &[u8]) -> Result<String> {
    let mut command = Command::new("spirv-val");
    command
        .args(["--target-env", "vulkan1.2", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = match command.spawn() {
        Ok(child) => child,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Ok("spirv-val is not on PATH: not validated".into());
        }
        Err(error) => return Err(error).context("cannot run spirv-val"),
    };
    // spirv-val reads all of its input before it writes: no deadlock between the two pipes.
    child.stdin.take().context("spirv-val has no input")?.write_all(bytes).context("cannot write to spirv-val")?;
    let output = child.wait_with_output().context("cannot run spirv-val")?;
    if !output.status.success() {
        bail!("spirv-val rejects the module: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok("spirv-val (vulkan1.2) finds no fault".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::kernel;
    use rspirv::binary::Assemble;

    #[test]
    fn an_undecorated_multiplication_is_rejected() {
        let mut module = kernel(|b, float, x| {
            b.f_mul(float, None, x, x).unwrap();
        });
        let error = no_contraction(&module.assemble()).unwrap_err().to_string();
        assert!(error.starts_with("1 float operations lack NoContraction"), "{error}");
        crate::postprocess::forbid_contraction(&mut module);
        no_contraction(&module.assemble()).unwrap();
    }

    #[test]
    fn cut_off_words_are_an_error() {
        let words = kernel(|_, _, _| {}).assemble();
        assert!(no_contraction(&words[..words.len() - 1]).is_ok(), "OpFunctionEnd is one word");
        assert!(no_contraction(&[0, 0, 0, 0, 0, 9 << 16]).is_err());
    }
}
