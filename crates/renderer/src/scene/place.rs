//! Checks of meshes, instances and their places.

use super::check::{LARGEST, PARALLEL, emission, number, triple, vector, whole};
use super::document::{Document, Path};
use super::error::SceneError;
use super::file::{MeshTable, Numbers, PlaceTable};
use super::generated::{self, GENERATED};
use super::limits::MAX_SURFACES;
use super::model::{self, Model, Part};
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use std::path::Path as FilePath;

/// Where something is put.
pub(super) fn place(document: &Document<'_>, path: &Path, table: Option<&PlaceTable>) -> Result<DAffine3, SceneError> {
    let Some(table) = table else { return Ok(DAffine3::IDENTITY) };
    let path = path.key("place");
    if let Some(rows) = &table.matrix {
        if table.translate.is_some() || table.rotate_degrees.is_some() || table.scale.is_some() {
            let problem = "is there beside `translate`, `rotate_degrees` or `scale`; keep one or the other";
            return Err(document.field_error(&path.key("matrix"), problem));
        }
        let mut columns = [DVec3::ZERO; 4];
        for (row, numbers) in rows.0.iter().enumerate() {
            for (column, &x) in numbers.0.iter().enumerate() {
                let at = path.key("matrix").index(row).index(column);
                columns[column][row] = number(document, &at, x, (-LARGEST, LARGEST), "an element of a matrix")?;
            }
        }
        let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let size = matrix.x_axis.length() * matrix.y_axis.length() * matrix.z_axis.length();
        if !(matrix.determinant().abs() > PARALLEL * PARALLEL * size) {
            let problem = "has no inverse: it makes the mesh flat; give three rows [x, y, z, translation] that do not";
            return Err(document.field_error(&path.key("matrix"), problem));
        }
        return Ok(DAffine3 { matrix3: matrix, translation: columns[3] });
    }
    let translation = match table.translate {
        Some(by) => vector(document, &path.key("translate"), by)?,
        None => DVec3::ZERO,
    };
    let angles = match table.rotate_degrees {
        Some(by) => triple(document, &path.key("rotate_degrees"), by, (-36e3, 36e3), "an angle (degrees)")?,
        None => DVec3::ZERO,
    };
    let scale = number(document, &path.key("scale"), table.scale.unwrap_or(1.0), (1e-9, LARGEST), "a scale")?;
    let [x, y, z] = angles.to_array().map(f64::to_radians);
    let turn = DQuat::from_euler(EulerRot::ZYX, z, y, x);
    Ok(DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, translation))
}

/// The parts of a mesh, before they are put in their place.
pub(super) fn mesh(
    document: &Document<'_>,
    path: &Path,
    table: &MeshTable,
    folder: &FilePath,
) -> Result<Model, SceneError> {
    match (&table.file, &table.vertices, &table.triangles) {
        (Some(file), None, None) => {
            let refuse = |problem: String| document.field_error(&path.key("file"), problem);
            if table.normals.is_some() || table.uv.is_some() {
                return Err(refuse(
                    "is there beside `normals` or `uv`, which the file has itself; remove these".into(),
                ));
            }
            if let Some(name) = file.strip_prefix("built-in:") {
                let known = GENERATED.map(|name| format!("\"built-in:{name}\"")).join(", ");
                return generated::model(name)
                    .ok_or_else(|| refuse(format!("is none of the meshes {known}; name one")));
            }
            model::read(&folder.join(file)).map_err(|error| match error {
                SceneError::Model { path, problem } => refuse(format!("is `{path}`, which {problem}")),
                other => other,
            })
        }
        (None, Some(vertices), Some(triangles)) => {
            let part = inline(document, path, table, vertices, triangles)?;
            Ok(Model { parts: vec![part], ..Model::default() })
        }
        _ => {
            Err(document.field_error(path, "must have either a `file` or `vertices` and `triangles`; add one of them"))
        }
    }
}

fn inline(
    document: &Document<'_>,
    path: &Path,
    table: &MeshTable,
    vertices: &[Numbers<3>],
    triangles: &[Numbers<3>],
) -> Result<Part, SceneError> {
    let mut part = Part { name: table.name.clone().unwrap_or_default(), ..Part::default() };
    for (i, &vertex) in vertices.iter().enumerate() {
        part.positions.push(vector(document, &path.key("vertices").index(i), vertex)?);
    }
    if triangles.is_empty() || triangles.len() > MAX_SURFACES {
        let problem = format!("has {} triangles, but a mesh has 1 to {MAX_SURFACES}; change it", triangles.len());
        return Err(document.field_error(&path.key("triangles"), problem));
    }
    let last = vertices.len().saturating_sub(1) as u32;
    for (i, triangle) in triangles.iter().enumerate() {
        let mut corners = [0; 3];
        for (k, (corner, &index)) in corners.iter_mut().zip(&triangle.0).enumerate() {
            let at = path.key("triangles").index(i).index(k);
            if index.fract() != 0.0 {
                return Err(document.field_error(&at, format!("is {index}, but vertices are counted whole, from 0")));
            }
            *corner = whole(document, &at, index as i64, (0, last), "the index of a vertex")?;
        }
        part.triangles.push(corners);
    }
    let as_many = |key: &str, count: usize| {
        if count == vertices.len() {
            return Ok(());
        }
        let problem = format!("has {count} entries, but there are {} vertices; give one each", vertices.len());
        Err(document.field_error(&path.key(key), problem))
    };
    if let Some(normals) = &table.normals {
        as_many("normals", normals.len())?;
        for (i, &normal) in normals.iter().enumerate() {
            part.normals.push(vector(document, &path.key("normals").index(i), normal)?);
        }
    }
    if let Some(uv) = &table.uv {
        as_many("uv", uv.len())?;
        for (i, pair) in uv.iter().enumerate() {
            for (k, &x) in pair.0.iter().enumerate() {
                let at = path.key("uv").index(i).index(k);
                number(document, &at, x, (-8192.0, 8192.0), "a texture coordinate")?;
            }
            part.uv.push(pair.0);
        }
    }
    Ok(part)
}

/// The radiance of a table that may have one.
pub(super) fn radiance(
    document: &Document<'_>,
    path: &Path,
    value: Option<Numbers<3>>,
) -> Result<Option<DVec3>, SceneError> {
    value.map(|value| emission(document, &path.key("radiance"), value, "a radiance (W/sr/m²)")).transpose()
}
