//! Movie as MP4 with the codec AV1.
//!
//! ```text
//! Y = 0.2126 R + 0.7152 G + 0.0722 B,   Cb = (B − Y)/1.8556,   Cr = (R − Y)/1.5748
//! ```
//!
//! The colours are those of ITU-R BT.709 in the limited range, with one Cb and Cr for four pixels,
//! which all players understand.

use image::RgbImage;
use muxide::api::{Muxer, MuxerBuilder, VideoCodec};
use rav1e::Context;
use rav1e::color::{
    ChromaSampling, ColorDescription, ColorPrimaries, MatrixCoefficients, PixelRange, TransferCharacteristics,
};
use rav1e::config::{Config, EncoderConfig, SpeedSettings};
use rav1e::data::{EncoderStatus, FrameType, Rational};

use super::movie::Movie;

/// Speed of the encoder, of which 10 is the fastest.
const SPEED: u8 = 10;

/// Coarseness of the levels, 0 to 255: thin lines stay sharp.
const QUANTIZER: usize = 70;

/// Largest number of frames between those that are complete in themselves.
const KEY_FRAMES: u64 = 60;

/// Encoder of a movie.
pub(super) struct Mp4Movie {
    context: Context<u8>,
    muxer: Muxer<Vec<u8>>,
    fps: f64,
}

impl Mp4Movie {
    pub(super) fn new([width, height]: [u32; 2], fps: f64) -> Result<Self, String> {
        let encoder = EncoderConfig {
            width: width as usize,
            height: height as usize,
            // A thousandth of a frame per second is more than a player resolves.
            time_base: Rational::new(1000, (1000.0 * fps).round().max(1.0) as u64),
            chroma_sampling: ChromaSampling::Cs420,
            pixel_range: PixelRange::Limited,
            color_description: Some(ColorDescription {
                color_primaries: ColorPrimaries::BT709,
                transfer_characteristics: TransferCharacteristics::BT709,
                matrix_coefficients: MatrixCoefficients::BT709,
            }),
            // Packets in the order of the frames.
            low_latency: true,
            max_key_frame_interval: KEY_FRAMES,
            quantizer: QUANTIZER,
            speed_settings: SpeedSettings::from_preset(SPEED),
            ..EncoderConfig::default()
        };
        let config = Config::new().with_encoder_config(encoder);
        let context = config.new_context().map_err(|error| error.to_string())?;
        let muxer = MuxerBuilder::new(Vec::new()).video(VideoCodec::Av1, width, height, fps).build();
        Ok(Self { context, muxer: muxer.map_err(|error| error.to_string())?, fps })
    }

    /// Writes the packets that are complete.
    fn drain(&mut self) -> Result<(), String> {
        loop {
            match self.context.receive_packet() {
                Ok(packet) => {
                    let time = packet.input_frameno as f64 / self.fps;
                    let is_key = packet.frame_type == FrameType::KEY;
                    let written = self.muxer.write_video(time, &packet.data, is_key);
                    written.map_err(|error| error.to_string())?;
                }
                Err(EncoderStatus::Encoded) => {}
                Err(EncoderStatus::NeedMoreData | EncoderStatus::LimitReached) => return Ok(()),
                Err(error) => return Err(error.to_string()),
            }
        }
    }
}

impl Movie for Mp4Movie {
    fn add(&mut self, picture: &RgbImage) -> Result<(), String> {
        let mut frame = self.context.new_frame();
        for (plane, values) in frame.planes.iter_mut().zip(planes(picture)) {
            plane.copy_from_raw_u8(&values.1, values.0, 1);
        }
        self.context.send_frame(frame).map_err(|error| error.to_string())?;
        self.drain()
    }

    fn finish(mut self: Box<Self>) -> Result<Vec<u8>, String> {
        self.context.flush();
        self.drain()?;
        let mut muxer = self.muxer;
        muxer.finish_in_place().map_err(|error| error.to_string())?;
        Ok(muxer.into_writer())
    }
}

/// Returns brightness, Cb and Cr of a picture with even sides: width and values of each.
fn planes(picture: &RgbImage) -> [(usize, Vec<u8>); 3] {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let part = |[red, green, blue]: [f64; 3]| 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let level = |value: f64| value.round().clamp(0.0, 255.0) as u8;
    let colour = |column: usize, row: usize| {
        picture.get_pixel(column as u32, row as u32).0.map(|channel| f64::from(channel) / 255.0)
    };
    let pixels = picture.pixels().map(|pixel| pixel.0.map(|channel| f64::from(channel) / 255.0));
    let bright = pixels.map(|pixel| level(16.0 + 219.0 * part(pixel))).collect();
    let (mut blue, mut red) = (Vec::new(), Vec::new());
    for row in (0..height).step_by(2) {
        for column in (0..width).step_by(2) {
            let four =
                [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| colour(column + right, row + down));
            let mean: [f64; 3] =
                std::array::from_fn(|k| four.iter().map(|pixel| pixel[k]).sum::<f64>() / 4.0);
            let y = part(mean);
            blue.push(level(128.0 + 224.0 * (mean[2] - y) / 1.8556));
            red.push(level(128.0 + 224.0 * (mean[0] - y) / 1.5748));
        }
    }
    [(width, bright), (width / 2, blue), (width / 2, red)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_the_levels_of_the_standard() {
        let levels = |colour: [u8; 3]| {
            planes(&RgbImage::from_pixel(2, 2, image::Rgb(colour))).map(|(_, values)| values[0])
        };
        assert_eq!(levels([255; 3]), [235, 128, 128]);
        assert_eq!(levels([0; 3]), [16, 128, 128]);
        // ITU-R BT.709: the red primary.
        assert_eq!(levels([255, 0, 0]), [63, 102, 240]);
    }

    #[test]
    fn every_picture_is_a_frame_of_the_file() {
        let mut movie = Box::new(Mp4Movie::new([64, 48], 10.0).expect("an encoder"));
        for at in 0..5_u32 {
            let picture =
                RgbImage::from_fn(64, 48, |x, _| image::Rgb([if x < 10 * at { 200 } else { 20 }; 3]));
            movie.add(&picture).expect("added");
        }
        let bytes = movie.finish().expect("a file");
        let has = |word: &[u8]| bytes.windows(word.len()).any(|part| part == word);
        assert!(has(b"ftyp") && has(b"av01") && has(b"av1C") && has(b"moov"));
        // The table of sample sizes: version, one size for all, number of samples.
        let at = bytes.windows(4).position(|part| part == b"stsz").expect("sample sizes");
        assert_eq!(bytes[at + 12..at + 16], 5_u32.to_be_bytes());
    }
}
