//! Pictures for the page: as PNG, as text in a page.

use crate::chart::Palette;
use crate::color::{Cat, Primaries, Xy, adapt};
use crate::display::transfer::srgb_encode;
use crate::{Error, Result, invalid};

/// Delta E of the error map's brightest colour.
pub const MOST_DELTA_E: f64 = 10.0;

/// A picture for an sRGB screen whose white is `white_y`: adapted, what is brighter is white.
pub fn shown(xyz: &[f32], width: usize, white: Xy, white_y: f64) -> Result<Vec<u8>> {
    let Some(rgb) = Primaries::BT709.from_xyz() else { return invalid!("BT.709 spans no area") };
    let matrix = rgb.times(&adapt::von_kries(Cat::Cmccat2000, white, Xy::D65, 1.0)?).scaled(1.0 / white_y);
    let pixel = |p: &[f32]| matrix.apply([p[0], p[1], p[2]].map(f64::from)).map(code);
    png(&xyz.chunks_exact(3).flat_map(pixel).collect::<Vec<u8>>(), width)
}

/// A map of errors from 0, black, to [`MOST_DELTA_E`].
pub fn error_map(map: &[f32], width: usize) -> Result<Vec<u8>> {
    let palette: Palette = "hot".parse()?;
    let pixel = |d: &f32| palette.colour((f64::from(*d) / MOST_DELTA_E).clamp(0.0, 1.0)).map(|c| code(c.into()));
    png(&map.iter().flat_map(pixel).collect::<Vec<u8>>(), width)
}

/// What a screen takes for linear light.
fn code(linear: f64) -> u8 {
    (255.0 * srgb_encode(linear.clamp(0.0, 1.0)) + 0.5) as u8
}

fn png(rgb: &[u8], width: usize) -> Result<Vec<u8>> {
    let failed = |e: png::EncodingError| Error::Invalid(e.to_string());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, (rgb.len() / 3 / width.max(1)) as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(rgb).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}
