//! Names of files that are not there yet, and pictures as PNG.

use eframe::egui::ColorImage;
use std::io::{self, Write};
use std::path::PathBuf;

/// The first of `STEM-0001.ENDING`, `STEM-0002.ENDING` .. that is not there.
///
/// # Errors
/// Where ten thousand of them are.
pub fn free_name(stem: &str, ending: &str) -> io::Result<PathBuf> {
    let names = (1..10_000).map(|n| PathBuf::from(format!("{stem}-{n:04}.{ending}")));
    let mut free = names.filter(|path| !path.exists());
    free.next().ok_or_else(|| {
        io::Error::new(io::ErrorKind::AlreadyExists, format!("{stem}-0001 to -9999 exist"))
    })
}

/// Writes a picture as PNG.
///
/// # Errors
/// Where it cannot be written.
pub fn write_png(file: impl Write, image: &ColorImage) -> io::Result<()> {
    let too_large = || io::Error::new(io::ErrorKind::InvalidInput, "the picture is too large");
    let [wide, high] = image.size.map(|side| u32::try_from(side).map_err(|_| too_large()));
    let mut encoder = png::Encoder::new(file, wide?, high?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let bytes: Vec<u8> =
        image.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(&bytes).map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::write_png;
    use eframe::egui::{Color32, ColorImage};

    #[test]
    fn a_picture_is_read_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut image = ColorImage::filled([3, 2], Color32::from_rgb(1, 2, 3));
        image.pixels[4] = Color32::from_rgb(200, 100, 0);
        write_png(std::fs::File::create(&path).unwrap(), &image).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut bytes = [0; 18];
        reader.next_frame(&mut bytes).unwrap();
        assert_eq!((&bytes[..3], &bytes[12..15]), (&[1, 2, 3][..], &[200, 100, 0][..]));
    }
}
