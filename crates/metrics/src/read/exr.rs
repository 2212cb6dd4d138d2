//! `OpenEXR`: linear floats as they are.

use super::{Decoded, Trouble, check_sides};
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers};
use std::io::Cursor;

/// Decodes an EXR: the first layer that has R, G and B, at full resolution.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, Trouble> {
    let header = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
    for layer in &header.headers {
        check_sides(layer.layer_size.width(), layer.layer_size.height())?;
    }
    let decoded = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0f32; 3]; size.area()]),
            |(width, rgb), at, (red, green, blue)| rgb[at.y() * *width + at.x()] = [red, green, blue],
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))?;
    let size = decoded.layer_data.size;
    Ok(Decoded { width: size.width(), height: size.height(), rgb: decoded.layer_data.channel_data.pixels.1 })
}
