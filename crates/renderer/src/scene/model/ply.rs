//! PLY: points and polygons (Turk, "The PLY Polygon File Format", 1994).

use super::{Finish, Model, Part, fan};
use crate::scene::text::one_line;
use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

#[derive(Default)]
struct Vertex {
    position: DVec3,
    normal: DVec3,
    uv: [f64; 2],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Char(x) => f64::from(x),
            Property::UChar(x) => f64::from(x),
            Property::Short(x) => f64::from(x),
            Property::UShort(x) => f64::from(x),
            Property::Int(x) => f64::from(x),
            Property::UInt(x) => f64::from(x),
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            _ => return PropertyAccessResult::Ignored,
        };
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "nx" => self.normal.x = value,
            "ny" => self.normal.y = value,
            "nz" => self.normal.z = value,
            "u" | "s" | "texture_u" => self.uv[0] = value,
            // The origin is at the bottom there, and at the top here.
            "v" | "t" | "texture_v" => self.uv[1] = 1.0 - value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

#[derive(Default)]
struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if name != "vertex_indices" && name != "vertex_index" {
            return PropertyAccessResult::Ignored;
        }
        // A negative index becomes one that no file has.
        let signed = |x: i64| u32::try_from(x).unwrap_or(u32::MAX);
        self.0 = match property {
            Property::ListChar(list) => list.into_iter().map(|x| signed(x.into())).collect(),
            Property::ListUChar(list) => list.into_iter().map(u32::from).collect(),
            Property::ListShort(list) => list.into_iter().map(|x| signed(x.into())).collect(),
            Property::ListUShort(list) => list.into_iter().map(u32::from).collect(),
            Property::ListInt(list) => list.into_iter().map(|x| signed(x.into())).collect(),
            Property::ListUInt(list) => list,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// What else a file has.
struct Rest;

impl PropertyAccess for Rest {
    fn new() -> Self {
        Self
    }
}

/// Reads a file's bytes.
pub(super) fn read(bytes: &[u8]) -> Result<Model, String> {
    let broken = |error: ply_rs_bw::parser::ParseError| {
        format!("is not a whole PLY file: {}; export it again", one_line(&error.to_string()))
    };
    let mut reader = Reader::new(bytes);
    let header = Parser::<Rest>::new().read_header(&mut reader).map_err(broken)?;
    let mut part = Part { name: "ply".to_string(), ..Part::default() };
    let mut left_out = std::collections::BTreeSet::new();
    for (name, element) in &header.elements {
        if element.count > bytes.len() {
            let count = element.count;
            return Err(format!(
                "says that it has {count} of `{}`, more than its bytes; export it again",
                one_line(name)
            ));
        }
        match name.as_str() {
            "vertex" => {
                let vertices = Parser::<Vertex>::new().read_payload_for_element(&mut reader, element, &header);
                let vertices = vertices.map_err(broken)?;
                let has = |name: &str| element.properties.contains_key(name);
                if !(has("x") && has("y") && has("z")) {
                    return Err("has points without `x`, `y` and `z`; export them".to_string());
                }
                part.positions = vertices.iter().map(|vertex| vertex.position).collect();
                if has("nx") && has("ny") && has("nz") {
                    part.normals = vertices.iter().map(|vertex| vertex.normal).collect();
                }
                if has("u") || has("s") || has("texture_u") {
                    part.uv = vertices.iter().map(|vertex| vertex.uv).collect();
                }
                if has("red") || has("diffuse_red") {
                    left_out.insert("colours of points".to_string());
                }
            }
            "face" => {
                let faces = Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header);
                let faces = faces.map_err(broken)?;
                part.triangles = faces.iter().flat_map(|face| fan(&face.0)).collect();
            }
            _ => {
                Parser::<Rest>::new().read_payload_for_element(&mut reader, element, &header).map_err(broken)?;
                left_out.insert(format!("elements `{}`", one_line(name)));
            }
        }
    }
    part.finish = Some(0);
    Ok(Model { parts: vec![part], finishes: vec![Finish::default()], left_out, ..Model::default() })
}
