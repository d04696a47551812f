//! SVG to PNG, without a display and with the same letters on every machine.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Width in pixels: enough to read every letter of a sheet of four.
const WIDTH: f32 = 1080.0;

pub(super) fn png(svg: &str) -> Result<Vec<u8>, String> {
    let mut options = Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let family = fonts.faces().next().and_then(|face| face.families.first()).map(|family| family.0.clone()).unwrap_or_default();
    fonts.set_sans_serif_family(family.clone());
    options.font_family = family;
    let tree = Tree::from_str(svg, &options).map_err(|error| format!("cannot be drawn: {error}"))?;
    let scale = WIDTH / tree.size().width();
    let size = tree.size().to_int_size().scale_by(scale).ok_or("is too large a picture")?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("is too large a picture")?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| format!("cannot be encoded: {error}"))
}
