//! glTF accessors: numbers in buffers, with every bound checked before anything is read.

use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, buffer};

/// The bytes of a view.
pub(super) fn view<'a>(view: &buffer::View<'_>, buffers: &'a [Vec<u8>]) -> Result<&'a [u8], String> {
    let buffer = buffers.get(view.buffer().index()).ok_or("refers to a buffer that it has not; export it again")?;
    let end = view.offset().checked_add(view.length());
    end.and_then(|end| buffer.get(view.offset()..end)).ok_or_else(|| {
        format!(
            "has buffer view {}, which reaches beyond the {} bytes of its buffer; export it again",
            view.index(),
            buffer.len()
        )
    })
}

/// The elements of an accessor of vectors of `N` numbers, as f64; whole numbers that stand for shares are made shares.
pub(super) fn numbers<const N: usize>(accessor: &Accessor<'_>, buffers: &[Vec<u8>]) -> Result<Vec<[f64; N]>, String> {
    let wrong = |what: &str| format!("has accessor {}, {what}; export it again", accessor.index());
    let components = match accessor.dimensions() {
        Dimensions::Scalar => 1,
        Dimensions::Vec2 => 2,
        Dimensions::Vec3 => 3,
        Dimensions::Vec4 => 4,
        _ => return Err(wrong("which is of matrices where vectors are wanted")),
    };
    if components != N {
        return Err(wrong(&format!("of {components} numbers each where {N} are wanted")));
    }
    if accessor.sparse().is_some() {
        return Err(wrong("which is sparse; sparse accessors are not read"));
    }
    let Some(from) = accessor.view() else { return Err(wrong("which has no buffer view")) };
    let bytes = view(&from, buffers)?;
    let each = accessor.data_type().size() * N;
    let stride = from.stride().unwrap_or(each);
    let count = accessor.count();
    let end = (count.max(1) - 1).checked_mul(stride).and_then(|all| all.checked_add(accessor.offset() + each));
    if count > 0 && (stride == 0 || end.is_none_or(|end| end > bytes.len())) {
        return Err(wrong(&format!("whose {count} elements reach beyond the {} bytes of their view", bytes.len())));
    }
    let share = |x: f64, most: f64| if accessor.normalized() { (x / most).max(-1.0) } else { x };
    let read = |at: usize| {
        let two = || [bytes[at], bytes[at + 1]];
        let four = || [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
        match accessor.data_type() {
            DataType::I8 => share(f64::from(bytes[at] as i8), 127.0),
            DataType::U8 => share(f64::from(bytes[at]), 255.0),
            DataType::I16 => share(f64::from(i16::from_le_bytes(two())), 32_767.0),
            DataType::U16 => share(f64::from(u16::from_le_bytes(two())), 65_535.0),
            DataType::U32 => f64::from(u32::from_le_bytes(four())),
            DataType::F32 => f64::from(f32::from_le_bytes(four())),
        }
    };
    let size = accessor.data_type().size();
    Ok((0..count).map(|i| std::array::from_fn(|axis| read(accessor.offset() + i * stride + axis * size))).collect())
}
