//! Movie as an animated GIF.
//!
//! A GIF has 256 colours. They are the same for all frames, so that nothing flickers, and follow
//! from the picture: those of the colour scale, of walls and of the shades of text. A frame holds
//! only the pixels that differ from the one before it.

use std::collections::HashMap;

use gif::{DisposalMethod, Encoder, EncodingError, Repeat};
use image::RgbImage;

use super::movie::Movie;
use super::raster::{NO_VALUE, WALL};
use super::sheet::ColourKey;
use crate::drawing::{Colour, INK, PAPER};

/// Number of colours; the last one of a GIF stands for unchanged pixels.
const COLOURS: usize = 255;

/// Index of unchanged pixels.
const UNCHANGED: u8 = 255;

/// Shades of text and thin lines.
const SHADES: usize = 28;

/// Encoder of a movie.
pub(super) struct GifMovie {
    encoder: Encoder<Vec<u8>>,
    palette: Palette,
    size: [u16; 2],
    /// Time of a frame, hundredths of a second.
    delay: u16,
    /// Indices of the colours of the picture before.
    before: Vec<u8>,
}

impl GifMovie {
    pub(super) fn new(size: [u32; 2], key: &ColourKey, fps: f64) -> Result<Self, String> {
        let failed = |error: EncodingError| error.to_string();
        let palette = Palette::new(key);
        let size = size.map(|length| length as u16);
        let mut encoder = Encoder::new(Vec::new(), size[0], size[1], &palette.bytes()).map_err(failed)?;
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
        // Players take times below two hundredths of a second for a tenth.
        let delay = (100.0 / fps).round().clamp(2.0, 6000.0) as u16;
        Ok(Self { encoder, palette, size, delay, before: Vec::new() })
    }
}

impl Movie for GifMovie {
    fn add(&mut self, picture: &RgbImage) -> Result<(), String> {
        let now = self.palette.indices(picture);
        let [width, height] = self.size;
        let mut frame = match self.before.is_empty() {
            true => gif::Frame { width, height, buffer: now.clone().into(), ..gif::Frame::default() },
            false => difference(&self.before, &now, usize::from(width)),
        };
        frame.delay = self.delay;
        frame.dispose = DisposalMethod::Keep;
        frame.transparent = Some(UNCHANGED);
        self.before = now;
        self.encoder.write_frame(&frame).map_err(|error| error.to_string())
    }

    fn finish(self: Box<Self>) -> Result<Vec<u8>, String> {
        self.encoder.into_inner().map_err(|error| error.to_string())
    }
}

/// Returns the smallest rectangle in which a picture differs from the one before it, with its
/// changed pixels.
fn difference(before: &[u8], now: &[u8], width: usize) -> gif::Frame<'static> {
    let changed = || (0..now.len()).filter(|&pixel| now[pixel] != before[pixel]);
    // A picture that is the same still takes its time.
    let (mut left, mut right) = (width - 1, 0);
    for pixel in changed() {
        left = left.min(pixel % width);
        right = right.max(pixel % width);
    }
    let (top, bottom) = (changed().next().unwrap_or(0) / width, changed().next_back().unwrap_or(0) / width);
    let (left, right) = if left > right { (0, 0) } else { (left, right) };
    let rows = (top..=bottom).flat_map(|row| (left..=right).map(move |column| row * width + column));
    let index = |pixel: usize| if now[pixel] == before[pixel] { UNCHANGED } else { now[pixel] };
    gif::Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left + 1) as u16,
        height: (bottom - top + 1) as u16,
        buffer: rows.map(index).collect::<Vec<u8>>().into(),
        ..gif::Frame::default()
    }
}

/// Colours of a movie.
struct Palette {
    colours: Vec<Colour>,
    /// Index of each colour met so far; only searched, so that its order has no effect.
    known: HashMap<Colour, u8>,
}

impl Palette {
    /// Returns the colours for pictures with a colour scale.
    fn new(key: &ColourKey) -> Self {
        let mut colours = vec![PAPER, INK, WALL, NO_VALUE];
        let mix = |a: Colour, b: Colour, share: f64| -> Colour {
            std::array::from_fn(|k| {
                (f64::from(a[k]) + share * (f64::from(b[k]) - f64::from(a[k]))).round() as u8
            })
        };
        colours.extend((1..SHADES).map(|shade| mix(PAPER, INK, shade as f64 / SHADES as f64)));
        match key {
            ColourKey::Scale { colours: map, .. } => {
                let count = COLOURS - colours.len();
                colours.extend((0..count).map(|index| map.at(index as f64 / (count - 1) as f64)));
            }
            ColourKey::Zones => {
                let zones = [0.0, 2.0, 3.0].map(|zone| key.colour(zone));
                for zone in zones {
                    // Edges between a zone and its surroundings.
                    let steps = (0..12).map(|step| f64::from(step) / 12.0);
                    let others = [PAPER, WALL, INK].into_iter();
                    let mixed =
                        others.flat_map(|other| steps.clone().map(move |step| mix(zone, other, step)));
                    colours.extend(mixed);
                }
            }
        }
        colours.truncate(COLOURS);
        Self { colours, known: HashMap::new() }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.colours.as_flattened().to_vec();
        bytes.resize(3 * (COLOURS + 1), 0);
        bytes
    }

    /// Returns the indices of the nearest colours.
    fn indices(&mut self, picture: &RgbImage) -> Vec<u8> {
        let colours = &self.colours;
        let distance = |a: Colour, b: Colour| -> i32 {
            // Weights of the eye's sensitivity to red, green and blue.
            let square = |k: usize| (i32::from(a[k]) - i32::from(b[k])).pow(2);
            2 * square(0) + 4 * square(1) + 3 * square(2)
        };
        let nearest = |colour: Colour| -> u8 {
            let all = colours.iter().enumerate();
            all.min_by_key(|(_, other)| distance(colour, **other)).map_or(0, |(index, _)| index as u8)
        };
        picture.pixels().map(|pixel| *self.known.entry(pixel.0).or_insert_with(|| nearest(pixel.0))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::colours::Colours;

    #[test]
    fn colours_of_the_scale_are_met_within_a_few_levels() {
        for colours in [Colours::Viridis, Colours::Diverging, Colours::Turbo] {
            let key = ColourKey::Scale { colours, range: (0.0, 1.0) };
            let mut palette = Palette::new(&key);
            assert!(palette.colours.len() <= COLOURS && palette.bytes().len() == 768);
            for step in 0..=1000 {
                let wanted = key.colour(f64::from(step) / 1000.0);
                let picture = RgbImage::from_pixel(1, 1, image::Rgb(wanted));
                let index = palette.indices(&picture)[0];
                let found = palette.colours[usize::from(index)];
                let off = (0..3).map(|k| found[k].abs_diff(wanted[k])).max().unwrap_or(0);
                // The steepest part of `turbo` rises by twelve levels from a colour to the next.
                assert!(off <= 6, "{wanted:?} became {found:?}");
            }
        }
        let mut zones = Palette::new(&ColourKey::Zones);
        let exact = [PAPER, INK, WALL, ColourKey::Zones.colour(3.0)];
        for colour in exact {
            let picture = RgbImage::from_pixel(1, 1, image::Rgb(colour));
            let index = zones.indices(&picture)[0];
            assert_eq!(zones.colours[usize::from(index)], colour);
        }
    }

    #[test]
    fn frames_read_back_as_they_were_drawn() {
        let key = ColourKey::Scale { colours: Colours::Viridis, range: (0.0, 1.0) };
        // A square that moves over a constant background.
        let picture = |at: u32| {
            RgbImage::from_fn(40, 20, |x, y| {
                let is_square = (at..at + 6).contains(&x) && (5..11).contains(&y);
                image::Rgb(if is_square { Colours::Viridis.at(0.8) } else { PAPER })
            })
        };
        let mut movie = Box::new(GifMovie::new([40, 20], &key, 25.0).expect("an encoder"));
        (0..3).for_each(|at| movie.add(&picture(4 * at)).expect("written"));
        let bytes = movie.finish().expect("a file");
        let mut decoder = gif::DecodeOptions::new();
        decoder.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = decoder.read_info(&bytes[..]).expect("a GIF");
        let mut shown = RgbImage::new(40, 20);
        for at in 0..3 {
            let frame = decoder.read_next_frame().expect("a frame").expect("three of them").clone();
            assert_eq!(frame.delay, 4);
            for (index, pixel) in frame.buffer.chunks(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
                let width = u32::from(frame.width);
                let place = [
                    u32::from(frame.left) + index as u32 % width,
                    u32::from(frame.top) + index as u32 / width,
                ];
                shown.put_pixel(place[0], place[1], image::Rgb([pixel[0], pixel[1], pixel[2]]));
            }
            for (found, wanted) in shown.pixels().zip(picture(4 * at).pixels()) {
                let off = (0..3).map(|k| found[k].abs_diff(wanted[k])).max().unwrap_or(0);
                assert!(off <= 4, "{wanted:?} became {found:?}");
            }
        }
        assert!(decoder.read_next_frame().expect("an end").is_none());
    }

    #[test]
    fn only_changed_pixels_are_written() {
        let before = [0, 0, 0, 0, 1, 0, 0, 0, 0];
        let now = [0, 0, 0, 0, 1, 2, 0, 3, 0];
        let frame = difference(&before, &now, 3);
        assert_eq!((frame.left, frame.top, frame.width, frame.height), (1, 1, 2, 2));
        assert_eq!(&frame.buffer[..], [UNCHANGED, 2, 3, UNCHANGED]);
        let same = difference(&now, &now, 3);
        assert_eq!((same.width, same.height, &same.buffer[..]), (1, 1, &[UNCHANGED][..]));
    }
}
