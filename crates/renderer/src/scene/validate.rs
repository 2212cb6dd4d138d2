//! From the fields of a file to a scene that can be rendered, or to the first thing that is wrong.

use super::content::{Content, Lamps, Pictures, Shape, Substance};
use super::document::{Document, Path};
use super::error::SceneError;
use super::file::{InstanceTable, MeshTable, SceneFile};
use super::import::substance;
use super::lamps::{Lamp, lamp};
use super::limits::{MAX_LIGHTS, MAX_SURFACES};
use super::meshes::{self, Assembly, Look};
use super::model::{self, Model};
use super::place::{mesh, place, radiance};
use super::surfaces::{Palette, disc, quad, sphere};
use super::text::{nearest, one_line};
use super::view::{camera, render};
use super::{RenderDefaults, load};
use glam::{DAffine3, DVec3};
use std::path::Path as FilePath;

/// Deepest nesting of included files.
const MAX_DEPTH: u32 = 16;

/// Checks everything but the syntax. Returns what is worth a note beside the scene.
pub(super) fn validate(
    document: &Document<'_>,
    file: &SceneFile,
) -> Result<(RenderDefaults, Content, Vec<String>), SceneError> {
    let top = Path::default();
    let Some(view) = &file.camera else {
        let problem = "lacks the field `camera`; add a table [camera] with position, target and vertical_fov_degrees";
        return Err(document.field_error(&top, problem));
    };
    let camera = camera(document, view)?;
    let defaults = render(document, &file.render)?;
    let mut builder = Builder::default();
    builder.add(document, file, 0)?;
    let Builder { palette, assembly, lamps, mut notes, .. } = builder;
    let (content, note) = assembly.finish(camera, palette, lamps);
    notes.extend(note);
    whole_scene(document, &content)?;
    Ok((defaults, content.localised(), notes))
}

/// A scene while files are added to it.
#[derive(Default)]
struct Builder {
    palette: Palette,
    assembly: Assembly,
    lamps: Lamps,
    notes: Vec<String>,
    /// Meshes by their names, for instances.
    meshes: Vec<(String, Known)>,
}

/// A mesh that instances can show.
struct Known {
    model: Model,
    looks: Vec<Look>,
}

impl Builder {
    fn add(&mut self, document: &Document<'_>, file: &SceneFile, depth: u32) -> Result<(), SceneError> {
        let top = Path::default();
        let folder = document.folder();
        for (i, other) in file.include.iter().enumerate() {
            self.include(document, &top.key("include").index(i), &folder.join(other), depth)?;
        }
        for (name, table) in &file.materials {
            let path = top.key("materials");
            let picture = |builder: &mut Self, key: &str, file: &Option<String>, srgb| {
                let at = path.key(name).key(key);
                file.as_ref().map(|file| builder.picture(document, &at, &folder.join(file), srgb)).transpose()
            };
            let pictures = Pictures {
                colour: picture(self, "texture", &table.texture, true)?,
                roughness: picture(self, "roughness_texture", &table.roughness_texture, false)?,
                normal: picture(self, "normal_texture", &table.normal_texture, false)?,
                emission: picture(self, "emission_texture", &table.emission_texture, true)?,
                ..Pictures::default()
            };
            self.palette.add(document, &path, name, table, pictures)?;
        }
        let Self { palette, assembly, .. } = self;
        for (i, table) in file.quads.iter().enumerate() {
            let path = named(&top.key("quads").index(i), table.name.as_ref());
            assembly.add(quad(document, &path, table, palette)?);
        }
        for (i, table) in file.spheres.iter().enumerate() {
            let path = named(&top.key("spheres").index(i), table.name.as_ref());
            assembly.add(sphere(document, &path, table, palette)?);
        }
        for (i, table) in file.discs.iter().enumerate() {
            let path = named(&top.key("discs").index(i), table.name.as_ref());
            assembly.add(disc(document, &path, table, palette)?);
        }
        for (i, table) in file.meshes.iter().enumerate() {
            let path = named(&top.key("meshes").index(i), table.name.as_ref());
            self.mesh(document, &path, table, &folder)?;
        }
        for (i, table) in file.instances.iter().enumerate() {
            let path = named(&top.key("instances").index(i), table.name.as_ref());
            self.instance(document, &path, table)?;
        }
        for (i, table) in file.lights.iter().enumerate() {
            let path = named(&top.key("lights").index(i), table.name.as_ref());
            match lamp(document, &path, table, &folder)? {
                Lamp::Point(point) => self.lamps.points.push(point),
                Lamp::Sun(sun) => self.lamps.suns.push(sun),
                Lamp::Sky(..) if self.lamps.sky.is_some() => {
                    let problem = "is a second environment, but a scene has one; remove one of them";
                    return Err(document.field_error(&path, problem));
                }
                Lamp::Sky(panorama, factor, turned) => {
                    let key = if table.file.is_some() { "file" } else { "radiance" };
                    let sky = self.assembly.add_sky(&panorama, factor, turned);
                    self.lamps.sky = Some(sky.map_err(|problem| document.field_error(&path.key(key), problem))?);
                }
            }
        }
        Ok(())
    }

    /// Adds the file that `path` names.
    fn include(&mut self, document: &Document<'_>, path: &Path, file: &FilePath, depth: u32) -> Result<(), SceneError> {
        let refuse = |problem: String| Err(document.field_error(path, problem));
        if depth == MAX_DEPTH {
            return refuse(format!("is the {MAX_DEPTH}th file that includes another; does one include itself?"));
        }
        let name = file.to_string_lossy();
        let text = match load::text(file) {
            Ok(text) => text,
            Err(reason) => return refuse(format!("is `{}`, which cannot be read: {reason}", one_line(&name))),
        };
        let included = Document::parse(&name, &text)?;
        let fields = included.fields()?;
        if fields.camera.is_some() {
            let problem = "is in a file that is included; the camera belongs into the one that includes it";
            return Err(included.field_error(&Path::default().key("camera"), problem));
        }
        self.add(&included, &fields, depth + 1)
    }

    fn picture(
        &mut self,
        document: &Document<'_>,
        path: &Path,
        file: &FilePath,
        srgb: bool,
    ) -> Result<u32, SceneError> {
        let picture = model::picture(file, srgb).and_then(|picture| self.assembly.add_picture(&picture));
        picture.map_err(|problem| document.field_error(path, format!("names a file that {problem}")))
    }

    fn mesh(
        &mut self,
        document: &Document<'_>,
        path: &Path,
        table: &MeshTable,
        folder: &FilePath,
    ) -> Result<(), SceneError> {
        let model = mesh(document, path, table, folder)?;
        let at = place(document, path, table.place.as_ref())?;
        let radiance = radiance(document, path, table.radiance)?;
        let material = match &table.material {
            Some(name) => Some(self.palette.find(document, &path.key("material"), name)?),
            None if model.finishes.is_empty() && radiance.is_some() => Some(self.palette.black()),
            None if model.finishes.is_empty() => {
                let problem =
                    "lacks the field `material`; add the name of a material, or a `radiance` to make it a light";
                return Err(document.field_error(path, problem));
            }
            None => None,
        };
        if let Some(file) = &table.file {
            self.notes.extend(meshes::left_out(file, &model));
        }
        let looks = self.looks(document, path, &model, material, radiance, table.flat)?;
        if !table.hidden {
            self.show(document, path, &model, &looks, &at)?;
        }
        if let Some(name) = &table.name {
            self.meshes.push((name.clone(), Known { model, looks }));
        }
        Ok(())
    }

    /// How each part of a model looks.
    fn looks(
        &mut self,
        document: &Document<'_>,
        path: &Path,
        model: &Model,
        material: Option<usize>,
        radiance: Option<DVec3>,
        flat: bool,
    ) -> Result<Vec<Look>, SceneError> {
        let Self { palette, assembly, .. } = self;
        let mut pictures = Vec::new();
        let mut finishes = Vec::new();
        if material.is_none() {
            for picture in &model.pictures {
                let added = assembly.add_picture(picture).map_err(|problem| document.field_error(path, problem))?;
                pictures.push(added);
            }
            for finish in &model.finishes {
                finishes.push(palette.push(substance(finish), finish.pictures(&pictures)));
            }
        }
        let mut looks = Vec::new();
        for part in &model.parts {
            let finish = part.finish.unwrap_or(0);
            let index = material.unwrap_or_else(|| finishes[finish]);
            let own = if material.is_none() { meshes::emission(&model.finishes[finish]) } else { None };
            let radiance = radiance.or(own);
            let textured = palette.pictures[index].any();
            if material.is_some() && textured && part.uv.is_empty() {
                let problem =
                    "has a material with a texture, but no texture coordinates; add them or use another material";
                return Err(document.field_error(path, problem));
            }
            if radiance.is_some() && palette.pictures[index].cutoff > 0.0 {
                let problem = "emits, but has holes; choose another material or remove the emission";
                return Err(document.field_error(path, problem));
            }
            if radiance.is_some() && !palette.materials[index].may_emit() {
                let problem = "emits, but is a mirror or dielectric; choose another material or remove the emission";
                return Err(document.field_error(path, problem));
            }
            let emission = palette.pictures[index].emission;
            looks.push(Look { material: index, textured, radiance, emission, flat });
        }
        Ok(looks)
    }

    fn show(
        &mut self,
        document: &Document<'_>,
        path: &Path,
        model: &Model,
        looks: &[Look],
        at: &DAffine3,
    ) -> Result<(), SceneError> {
        for (part, look) in model.parts.iter().zip(looks) {
            let added = self.assembly.add_part(&part.moved(at), *look);
            added.map_err(|problem| document.field_error(path, problem))?;
        }
        Ok(())
    }

    fn instance(&mut self, document: &Document<'_>, path: &Path, table: &InstanceTable) -> Result<(), SceneError> {
        let at = place(document, path, Some(&table.place))?;
        let Some(known) = self.meshes.iter().position(|(name, _)| *name == table.mesh) else {
            let meant = nearest(&table.mesh, self.meshes.iter().map(|(name, _)| name.as_str()));
            let meant = meant.map_or(String::new(), |name| format!(" (did you mean \"{}\"?)", one_line(name)));
            let unknown = one_line(&table.mesh);
            let problem = format!("names the unknown mesh \"{unknown}\"{meant}; give a [[meshes]] that `name`");
            return Err(document.field_error(&path.key("mesh"), problem));
        };
        let (name, known) = self.meshes.swap_remove(known);
        let looks = match &table.material {
            Some(material) => {
                let index = self.palette.find(document, &path.key("material"), material)?;
                self.looks(document, path, &known.model, Some(index), None, false)?
            }
            None => known.looks.clone(),
        };
        self.show(document, path, &known.model, &looks, &at)?;
        self.meshes.push((name, known));
        Ok(())
    }
}

fn named(path: &Path, name: Option<&String>) -> Path {
    match name {
        Some(name) => path.named(name),
        None => path.clone(),
    }
}

/// Checks that concern more than one object.
fn whole_scene(document: &Document<'_>, content: &Content) -> Result<(), SceneError> {
    let top = Path::default();
    let error = |problem: String| Err(document.field_error(&top, problem));
    let surfaces = content.surfaces.len();
    if surfaces == 0 {
        return error(
            "has no surface, so there is nothing to see; add [[quads]], [[spheres]], [[discs]] or [[meshes]]"
                .to_string(),
        );
    }
    if surfaces > MAX_SURFACES {
        return error(format!("has {surfaces} surfaces, but may have {MAX_SURFACES} at most; remove some"));
    }
    let lights = content.points.len()
        + content.suns.len()
        + usize::from(content.sky.is_some())
        + content.surfaces.iter().filter(|surface| surface.radiance.is_some()).count();
    if lights == 0 {
        return error("has no light, so it would be black; give a quad a `radiance` or add [[lights]]".to_string());
    }
    if lights > MAX_LIGHTS {
        return error(format!("has {lights} lights, but may have {MAX_LIGHTS} at most; remove some"));
    }
    // The kernels leave out the factors by which radiance changes in and out of glass, because they cancel on paths that
    // begin and end outside.
    if inside_glass(content, content.camera.position) {
        let problem = "is inside a dielectric sphere; put the camera outside of it";
        return Err(document.field_error(&top.key("camera").key("position"), problem));
    }
    for (i, point) in content.points.iter().enumerate() {
        if inside_glass(content, point.position) {
            let problem = "is inside a dielectric sphere; put the light outside of it";
            return Err(document.field_error(&top.key("lights").index(i).key("position"), problem));
        }
    }
    Ok(())
}

fn inside_glass(content: &Content, point: DVec3) -> bool {
    content.surfaces.iter().any(|surface| match surface.shape {
        Shape::Sphere { centre, radius } => {
            matches!(content.materials[surface.material], Substance::Dielectric(_)) && point.distance(centre) < radius
        }
        Shape::Quad { .. } | Shape::Disc { .. } | Shape::Triangle { .. } => false,
    })
}
