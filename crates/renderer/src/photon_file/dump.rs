//! Photons for other programs.

use super::PhotonFile;
use crate::output::to_srgb8;
use caustic_kernels::layout::Photon;
use caustic_kernels::trace::vector::unpack_direction;
use std::io::{self, Write};

impl PhotonFile {
    /// Writes a line for each photon, after one with the names of the columns: map, position (m, in the scene's coordinates), direction of
    /// travel, power (W) and index of the surface.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_csv(&self, to: &mut dyn Write) -> io::Result<()> {
        writeln!(to, "map,x,y,z,direction_x,direction_y,direction_z,power_red,power_green,power_blue,surface")?;
        for (header, photon) in self.each() {
            let [x, y, z] = self.position(photon);
            let d = unpack_direction(photon.direction);
            let [red, green, blue] = photon.power;
            let (map, surface) = (&self.header.maps[header].map, photon.primitive);
            writeln!(to, "{map},{x},{y},{z},{},{},{},{red},{green},{blue},{surface}", d.x, d.y, d.z)?;
        }
        Ok(())
    }

    /// Writes a point cloud in PLY (Turk, "The PLY Polygon File Format", 1994), binary: positions in double, since a scene may lie far from its
    /// origin; a colour for viewers, which is the power's without its strength; and all that a photon has.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_ply(&self, to: &mut dyn Write) -> io::Result<()> {
        let count: usize = self.photons.iter().map(Vec::len).sum();
        let maps: Vec<String> =
            self.header.maps.iter().enumerate().map(|(i, header)| format!("{i} {}", header.map)).collect();
        write!(
            to,
            "ply\nformat binary_little_endian 1.0\ncomment photons of {} by caustic {}; maps: {}\nelement vertex {count}\n",
            self.header.scene.replace(char::is_control, " "),
            self.header.version,
            maps.join(", ")
        )?;
        for (kind, names) in [
            ("double", &["x", "y", "z"][..]),
            ("float", &["direction_x", "direction_y", "direction_z", "power_red", "power_green", "power_blue"]),
            ("uchar", &["red", "green", "blue", "map"]),
            ("uint", &["surface"]),
        ] {
            for name in names {
                writeln!(to, "property {kind} {name}")?;
            }
        }
        writeln!(to, "end_header")?;
        for (header, photon) in self.each() {
            for x in self.position(photon) {
                to.write_all(&x.to_le_bytes())?;
            }
            for x in unpack_direction(photon.direction).to_array().into_iter().chain(photon.power) {
                to.write_all(&x.to_le_bytes())?;
            }
            let most = photon.power.into_iter().fold(f32::MIN_POSITIVE, f32::max);
            let [red, green, blue] = photon.power.map(|power| to_srgb8(power / most));
            to.write_all(&[red, green, blue, header as u8])?;
            to.write_all(&photon.primitive.to_le_bytes())?;
        }
        Ok(())
    }

    /// All photons, with the index of their map.
    fn each(&self) -> impl Iterator<Item = (usize, &Photon)> {
        self.photons.iter().enumerate().flat_map(|(header, photons)| photons.iter().map(move |photon| (header, photon)))
    }

    /// Where a photon is in the scene's coordinates, m.
    fn position(&self, photon: &Photon) -> [f64; 3] {
        std::array::from_fn(|axis| f64::from(photon.position[axis]) + self.header.origin[axis])
    }
}
