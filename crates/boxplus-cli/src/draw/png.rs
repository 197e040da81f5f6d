//! The SVG as pixels.

use resvg::{tiny_skia, usvg};
use std::sync::Arc;

/// Pixels of the PNG per pixel of the SVG: sharp on dense screens.
const SCALE: f32 = 2.0;

/// Inter (SIL Open Font License, `assets/Inter-OFL.txt`), so that text looks the same on a machine without fonts.
const INTER: [&[u8]; 2] =
    [include_bytes!("../../assets/Inter-Regular.ttf"), include_bytes!("../../assets/Inter-SemiBold.ttf")];

/// The drawing as the bytes of a PNG file; `None` where it has no area.
pub fn render(svg: &str) -> Option<Vec<u8>> {
    let mut fonts = usvg::fontdb::Database::new();
    INTER.iter().for_each(|font| fonts.load_font_data(font.to_vec()));
    let options = usvg::Options {
        font_family: "Inter".to_owned(),
        fontdb: Arc::new(fonts),
        ..usvg::Options::default()
    };
    let tree = usvg::Tree::from_str(svg, &options).ok()?;
    let size = tree.size().to_int_size().scale_by(SCALE)?;
    let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height())?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels.encode_png().ok()
}
