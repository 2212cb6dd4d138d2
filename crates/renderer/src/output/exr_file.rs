//! `OpenEXR`: the floats as they are, without loss, and how they came about.

use super::{Image, Layer, Metadata};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, LayerAttributes, ReadChannels, ReadLayers, SmallVec, Text,
    WritableImage, attribute::AttributeValue,
};
use std::io::Cursor;

/// The bytes of an EXR of 32-bit floats, compressed by ZIP: R, G and B, and the channels of layers, such as `direct.R`.
pub(super) fn encode(image: &Image, layers: &[Layer], metadata: &Metadata) -> Result<Vec<u8>, String> {
    let settings: Vec<String> = metadata.settings.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let mut attributes = LayerAttributes {
        software_name: Some(text(&format!("caustic {}", metadata.version))),
        ..LayerAttributes::default()
    };
    for (name, value) in [
        ("caustic.version", metadata.version.clone()),
        ("caustic.scene", metadata.scene.clone()),
        ("caustic.seed", metadata.seed.to_string()),
        ("caustic.settings", settings.join("\n")),
    ] {
        attributes.other.insert(text(name), AttributeValue::Text(text(&value)));
    }
    let channel = |name: &str, values: Vec<f32>| AnyChannel::new(text(name), FlatSamples::F32(values));
    let mut channels = SmallVec::new();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(channel(name, image.rgb.iter().map(|rgb| rgb[c]).collect()));
    }
    for layer in layers {
        let names = layer.kind.channels();
        for (c, name) in names.iter().enumerate() {
            let values = layer.values.iter().skip(c).step_by(names.len()).copied().collect();
            channels.push(channel(&format!("{}.{name}", layer.kind.name()), values));
        }
    }
    let size = (image.width as usize, image.height as usize);
    let layer = exr::prelude::Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut bytes = Vec::new();
    exr::prelude::Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|error| error.to_string())?;
    sort_attributes(&mut bytes).ok_or("the EXR encoder wrote a header that cannot be read")?;
    Ok(bytes)
}

/// The picture of an EXR.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let decoded = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0f32; 3]; size.area()]),
            |(width, rgb), at, (red, green, blue)| rgb[at.y() * *width + at.x()] = [red, green, blue],
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    let size = decoded.layer_data.size;
    let side = |pixels: usize| u32::try_from(pixels).map_err(|error| error.to_string());
    Ok(Image {
        width: side(size.width())?,
        height: side(size.height())?,
        rgb: decoded.layer_data.channel_data.pixels.1,
    })
}

/// Text of an attribute: what is not Latin-1, which is all that the encoder takes, becomes `?`.
fn text(value: &str) -> Text {
    let latin: String = value.chars().map(|c| if u32::from(c) < 256 && c != '\0' { c } else { '?' }).collect();
    Text::new_or_none(latin).unwrap_or_default()
}

/// Sorts the header's attributes by name: the encoder takes them from a hash map, in another order every time. The header
/// keeps its length, so that what comes after it stays where its offset table says.
fn sort_attributes(bytes: &mut [u8]) -> Option<()> {
    // Magic number and version, then attributes (name, 0, type, 0, length of the value, value), then 0.
    const START: usize = 8;
    let mut attributes = Vec::new();
    let mut at = START;
    while *bytes.get(at)? != 0 {
        let end_of = |from: usize| Some(from + bytes.get(from..)?.iter().position(|&byte| byte == 0)? + 1);
        let value = end_of(end_of(at)?)? + 4;
        let length = u32::from_le_bytes(bytes.get(value - 4..value)?.try_into().ok()?);
        let end = value.checked_add(length as usize)?;
        attributes.push(bytes.get(at..end)?.to_vec());
        at = end;
    }
    // An attribute's bytes begin with its name and a 0, which no name holds.
    attributes.sort_unstable();
    bytes.get_mut(START..at)?.copy_from_slice(&attributes.concat());
    Some(())
}
