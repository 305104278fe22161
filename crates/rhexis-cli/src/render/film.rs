//! A moving picture as APNG: one palette for all frames, and of each frame only what has changed.

use png::{BlendOp, ColorType, Compression, DisposeOp, Encoder, Filter};
use std::collections::BTreeMap;

/// Colours of the palette; its last entry is transparent: as in the frame before.
const MOST_COLOURS: usize = 255;
const UNCHANGED: u8 = 255;
/// How long the last frame stays \[s\].
const LAST: u16 = 2;

/// An opaque picture, row by row.
pub(super) struct Picture {
    pub width: u32,
    pub height: u32,
    /// Red, green, blue.
    pub pixels: Vec<[u8; 3]>,
}

/// The bytes of a film of pictures of one size.
///
/// # Errors
/// Where there are none, they differ in size, or the encoder refuses.
pub(super) fn encode(pictures: &[Picture], frames_per_second: u16) -> Result<Vec<u8>, String> {
    let Some(first) = pictures.first() else { return Err("there are no frames".to_owned()) };
    let (width, height) = (first.width, first.height);
    if pictures.iter().any(|picture| (picture.width, picture.height) != (width, height)) {
        return Err("frames differ in size".to_owned());
    }
    let colours = Palette::new(pictures);
    let write = || -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, width, height);
        encoder.set_color(ColorType::Indexed);
        encoder.set_palette(colours.entries.concat());
        encoder.set_trns([&[255; MOST_COLOURS][..], &[0]].concat());
        encoder.set_compression(Compression::High);
        encoder.set_filter(Filter::NoFilter);
        encoder.set_animated(pictures.len() as u32, 0)?;
        encoder.set_dispose_op(DisposeOp::None)?;
        let mut writer = encoder.write_header()?;
        let mut before: Vec<u8> = Vec::new();
        for (number, picture) in pictures.iter().enumerate() {
            let is_last = number + 1 == pictures.len();
            let (part, of) = if is_last { (LAST, 1) } else { (1, frames_per_second) };
            writer.set_frame_delay(part, of)?;
            let now: Vec<u8> = picture.pixels.iter().map(|&colour| colours.index(colour)).collect();
            let (area, rows) = changed(&before, &now, width);
            writer.set_blend_op(if number == 0 { BlendOp::Source } else { BlendOp::Over })?;
            writer.reset_frame_position()?;
            writer.set_frame_dimension(area[2], area[3])?;
            writer.set_frame_position(area[0], area[1])?;
            writer.write_image_data(&rows)?;
            before = now;
        }
        writer.finish()?;
        Ok(bytes)
    };
    write().map_err(|error| error.to_string())
}

/// The rectangle (x, y, width, height) that has changed, and its rows with what has not left out.
fn changed(before: &[u8], now: &[u8], width: u32) -> ([u32; 4], Vec<u8>) {
    let columns = width as usize;
    if before.is_empty() {
        return ([0, 0, width, (now.len() / columns) as u32], now.to_vec());
    }
    let differs: Vec<usize> = (0..now.len()).filter(|&at| before[at] != now[at]).collect();
    let (Some(first), Some(last)) = (differs.first(), differs.last()) else { return ([0, 0, 1, 1], vec![UNCHANGED]) };
    let (top, bottom) = (first / columns, last / columns);
    let left = differs.iter().map(|at| at % columns).min().unwrap_or(0);
    let right = differs.iter().map(|at| at % columns).max().unwrap_or(0);
    let row = |y: usize| (y * columns + left)..=(y * columns + right);
    let pixel = |at: usize| if before[at] == now[at] { UNCHANGED } else { now[at] };
    let rows = (top..=bottom).flat_map(row).map(pixel).collect();
    ([left, top, right - left + 1, bottom - top + 1].map(|side| side as u32), rows)
}

/// At most 255 colours and which of them stands for each colour of the pictures.
struct Palette {
    entries: Vec<[u8; 3]>,
    index: Vec<u8>,
}

/// Colours of one bucket: how many pixels, and the sums of their channels.
#[derive(Clone, Copy, Default)]
struct Bucket {
    count: u64,
    sums: [u64; 3],
}

impl Bucket {
    fn mean(&self) -> [u8; 3] {
        self.sums.map(|sum| ((sum + self.count / 2) / self.count.max(1)).min(255) as u8)
    }
}

/// Six bits of each channel.
fn bucket([r, g, b]: [u8; 3]) -> usize {
    (usize::from(r >> 2) << 12) | (usize::from(g >> 2) << 6) | usize::from(b >> 2)
}

impl Palette {
    /// By median cut (Heckbert 1982), the box with the largest spread of its pixels first.
    fn new(pictures: &[Picture]) -> Self {
        let mut buckets: BTreeMap<usize, Bucket> = BTreeMap::new();
        for colour in pictures.iter().flat_map(|picture| &picture.pixels) {
            let own = buckets.entry(bucket(*colour)).or_default();
            own.count += 1;
            own.sums.iter_mut().zip(colour).for_each(|(sum, value)| *sum += u64::from(*value));
        }
        let all: Vec<(usize, Bucket)> = buckets.into_iter().collect();
        let mut boxes = vec![all];
        while boxes.len() < MOST_COLOURS {
            let spreads = boxes.iter().map(|own| spread(own));
            let widest = spreads.enumerate().max_by(|a, b| a.1.1.total_cmp(&b.1.1).then(b.0.cmp(&a.0)));
            let Some((place, (channel, true))) = widest.map(|(place, (channel, wide))| (place, (channel, wide > 0.0)))
            else {
                break;
            };
            let mut own = boxes.swap_remove(place);
            own.sort_by_key(|(key, bucket)| (bucket.mean()[channel], *key));
            let half = own.iter().map(|(_, bucket)| bucket.count).sum::<u64>() / 2;
            let mut passed = 0;
            let at = own.iter().position(|(_, bucket)| {
                passed += bucket.count;
                passed > half
            });
            let rest = own.split_off(at.unwrap_or(0).clamp(1, own.len() - 1));
            boxes.extend([own, rest]);
        }
        let mut entries: Vec<[u8; 3]> = boxes.iter().map(|own| total(own).mean()).collect();
        let mut index = vec![0; 1 << 18];
        for (key, own) in boxes.iter().flatten() {
            index[*key] = nearest(&entries, own.mean());
        }
        // The transparent entry has the last place, whatever the number of colours.
        entries.resize(MOST_COLOURS + 1, [0; 3]);
        Self { entries, index }
    }

    fn index(&self, colour: [u8; 3]) -> u8 {
        self.index[bucket(colour)]
    }
}

fn total(own: &[(usize, Bucket)]) -> Bucket {
    own.iter().fold(Bucket::default(), |sum, (_, bucket)| Bucket {
        count: sum.count + bucket.count,
        sums: [0, 1, 2].map(|channel| sum.sums[channel] + bucket.sums[channel]),
    })
}

/// The channel that varies most in a box, and by how much: its range, weighed by the root of the number of pixels. So neither
/// large even areas nor single odd pixels take all colours.
fn spread(own: &[(usize, Bucket)]) -> (usize, f64) {
    let count = (total(own).count as f64).sqrt();
    let range = |channel: usize| {
        let values = own.iter().map(|(_, bucket)| bucket.mean()[channel]);
        f64::from(values.clone().max().unwrap_or(0) - values.min().unwrap_or(0))
    };
    let ranges = [0, 1, 2].map(range);
    let widest = (0..3).max_by(|&a, &b| ranges[a].total_cmp(&ranges[b])).unwrap_or(0);
    let can_be_cut = own.len() > 1;
    (widest, if can_be_cut { ranges[widest] * count } else { 0.0 })
}

fn nearest(entries: &[[u8; 3]], colour: [u8; 3]) -> u8 {
    let distance =
        |entry: &[u8; 3]| -> i32 { entry.iter().zip(colour).map(|(a, b)| (i32::from(*a) - i32::from(b)).pow(2)).sum() };
    (0..entries.len().min(MOST_COLOURS)).min_by_key(|&at| distance(&entries[at])).unwrap_or(0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(shift: usize) -> Picture {
        let pixel = |at: usize| {
            let (x, y) = (at % 40, at / 40);
            let inside = (10 + shift..20 + shift).contains(&x) && (10..20).contains(&y);
            if inside { [250, 40, 3 * x as u8] } else { [255, 255, 255] }
        };
        Picture { width: 40, height: 30, pixels: (0..40 * 30).map(pixel).collect() }
    }

    /// What a viewer shows: frames laid over each other.
    fn shown(bytes: &[u8]) -> Vec<Vec<u8>> {
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        let mut reader = decoder.read_info().unwrap();
        let count = reader.info().animation_control().unwrap().num_frames;
        let palette = reader.info().palette.clone().unwrap().to_vec();
        let mut canvas = vec![0; 40 * 30 * 3];
        let mut frames = Vec::new();
        for _ in 0..count {
            let mut buffer = vec![0; 40 * 30];
            reader.next_frame(&mut buffer).unwrap();
            let frame = *reader.info().frame_control().unwrap();
            for y in 0..frame.height {
                for x in 0..frame.width {
                    let index = usize::from(buffer[(y * frame.width + x) as usize]);
                    let at = 3 * ((y + frame.y_offset) * 40 + x + frame.x_offset) as usize;
                    if index != usize::from(UNCHANGED) {
                        canvas[at..at + 3].copy_from_slice(&palette[3 * index..3 * index + 3]);
                    }
                }
            }
            frames.push(canvas.clone());
        }
        frames
    }

    #[test]
    fn frames_come_back_as_they_were() {
        let pictures = [picture(0), picture(3), picture(3), picture(5)];
        let bytes = encode(&pictures, 10).unwrap();
        let frames = shown(&bytes);
        assert_eq!(frames.len(), 4);
        for (frame, picture) in frames.iter().zip(&pictures) {
            let worst = frame.iter().zip(picture.pixels.as_flattened()).map(|(a, b)| a.abs_diff(*b)).max();
            // Six bits of a channel are told apart: half a bucket.
            assert!(worst <= Some(2), "{worst:?}");
        }
        assert_eq!(bytes, encode(&pictures, 10).unwrap(), "the same pictures give the same bytes");
    }

    #[test]
    fn more_colours_than_a_palette_has_are_brought_together() {
        let pixels = (0..64 * 64).map(|at| [(at % 64 * 4) as u8, (at / 64 * 4) as u8, 128]).collect();
        let pictures = [Picture { width: 64, height: 64, pixels }];
        let palette = Palette::new(&pictures);
        let worst = pictures[0].pixels.iter().map(|&colour| {
            let entry = palette.entries[usize::from(palette.index(colour))];
            entry.iter().zip(colour).map(|(a, b)| a.abs_diff(b)).max().unwrap()
        });
        // 255 boxes of 4096 colours: four by four colours of four levels each, and half of that from their middle.
        assert!(worst.max() <= Some(16));
        assert!(encode(&[], 10).is_err());
    }
}
