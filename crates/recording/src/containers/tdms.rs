//! LabVIEW's TDMS files, by National Instruments' "TDMS File Format Internal Structure": a signal `/group/channel` per
//! channel of numbers, and `time(/group/channel)` for a channel with a time increment. Raw data of DAQmx is rejected.
//!
//! A file is a list of segments. A segment has a list of objects, which is new or continues the previous segment's
//! list, and chunks of raw data. Each chunk contains some values of every object.

use std::collections::HashMap;

use super::bytes::{Cursor, Order, Scalar};
use super::{Array, Container, Fault, Format, check_size};
use crate::Limits;
use crate::error::Problem;

const LEAD_IN_BYTES: usize = 28;

const META_DATA: u32 = 1 << 1;
const NEW_OBJECTS: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;

/// Raw data index of an object without data, and of an object with the index of the previous segment.
const NO_DATA: u32 = 0xffff_ffff;
const SAME_DATA: u32 = 0;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Number(Scalar),
    /// Seconds since 1904, and a fraction in 2^-64 s.
    Stamp,
    Text,
    /// A type without numbers, with the size of a value in bytes.
    Other(usize),
}

impl Kind {
    fn parse(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::Number(Scalar::I8),
            2 => Self::Number(Scalar::I16),
            3 => Self::Number(Scalar::I32),
            4 => Self::Number(Scalar::I64),
            5 | 0x21 => Self::Number(Scalar::U8),
            6 => Self::Number(Scalar::U16),
            7 => Self::Number(Scalar::U32),
            8 => Self::Number(Scalar::U64),
            9 | 0x19 => Self::Number(Scalar::F32),
            10 | 0x1a => Self::Number(Scalar::F64),
            0x44 => Self::Stamp,
            0x20 => Self::Text,
            0x0008_000c => Self::Other(8),
            0x0010_000d => Self::Other(16),
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::Number(scalar) => scalar.size(),
            Self::Stamp => 16,
            Self::Text => 0,
            Self::Other(size) => size,
        }
    }

    fn read(self, bytes: &[u8], order: Order) -> Option<f64> {
        match self {
            Self::Number(scalar) => scalar.read(bytes, order),
            Self::Stamp => {
                let (fraction, seconds) = match order {
                    Order::Little => (0, 8),
                    Order::Big => (8, 0),
                };
                let fraction = Scalar::U64.read(bytes.get(fraction..)?, order)?;
                Some(Scalar::I64.read(bytes.get(seconds..)?, order)? + fraction / 2f64.powi(64))
            }
            Self::Text | Self::Other(_) => None,
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Index {
    kind: Kind,
    count: usize,
    /// Size of all values in bytes.
    size: usize,
}

/// The values of a channel in a segment: `count` values, `stride` bytes apart, in each of `chunks` chunks.
#[derive(Debug, Clone, Copy)]
struct Run {
    start: usize,
    count: usize,
    stride: usize,
    chunks: usize,
    chunk_bytes: usize,
    order: Order,
}

#[derive(Debug, Clone, PartialEq)]
enum Property {
    Number(f64),
    Text(String),
    Other,
}

#[derive(Debug, Default)]
struct Channel {
    path: String,
    index: Option<Index>,
    runs: Vec<Run>,
    len: usize,
    increment_s: Option<f64>,
    offset_s: f64,
    unit: Option<String>,
}

enum ArraySource {
    Values(usize),
    Clock(usize),
}

pub(super) struct Tdms {
    bytes: Vec<u8>,
    channels: Vec<Channel>,
    arrays: Vec<Array>,
    sources: Vec<ArraySource>,
    limits: Limits,
}

impl Tdms {
    pub(super) fn open(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Problem> {
        let mut reader = Reader { bytes: &bytes, channels: vec![], by_path: HashMap::new(), active: vec![] };
        let mut at = 0;
        while at < bytes.len() {
            at = reader.segment(at)?;
        }
        let channels = reader.channels;
        let (mut arrays, mut sources) = (vec![], vec![]);
        for (index, channel) in channels.iter().enumerate() {
            let is_number = channel.index.is_some_and(|index| matches!(index.kind, Kind::Number(_) | Kind::Stamp));
            if channel.len == 0 || !is_number {
                continue;
            }
            if channel.increment_s.is_some() {
                let name = format!("time({})", channel.path);
                arrays.push(Array { unit: Some("s".into()), ..Array::new(name, vec![channel.len]) });
                sources.push(ArraySource::Clock(index));
            }
            arrays.push(Array { unit: channel.unit.clone(), ..Array::new(&channel.path, vec![channel.len]) });
            sources.push(ArraySource::Values(index));
        }
        if super::vectors(&arrays).is_empty() {
            return Err(Problem::no_signal(Format::Tdms, &[]));
        }
        Ok(Self { channels, arrays, sources, limits: limits.clone(), bytes })
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    channels: Vec<Channel>,
    by_path: HashMap<String, usize>,
    /// The objects of the segment with raw data, in the order of their data.
    active: Vec<usize>,
}

impl Reader<'_> {
    /// Reads the segment at `start` and returns the start of the next one.
    fn segment(&mut self, start: usize) -> Result<usize, Problem> {
        let damaged = |detail: &str| Format::Tdms.damaged(detail);
        let cut = || damaged("it is cut off");
        let mut lead_in = Cursor::new(self.bytes, Order::Little);
        lead_in.at = start;
        if lead_in.take(4).ok_or_else(cut)? != b"TDSm" {
            return Err(damaged("a segment does not begin with TDSm"));
        }
        let flags = lead_in.u32().ok_or_else(cut)?;
        let order = if flags & BIG_ENDIAN == 0 { Order::Little } else { Order::Big };
        lead_in.order = order;
        lead_in.u32().ok_or_else(cut)?;
        let (next, raw) = (lead_in.u64().ok_or_else(cut)?, lead_in.u64().ok_or_else(cut)?);
        if flags & DAQMX != 0 {
            return Err(damaged("it has raw data of DAQmx, which is not scaled"));
        }
        let left = self.bytes.len() - lead_in.at;
        // LabVIEW writes the length of a segment when the segment ends. Without the length, this segment is the last.
        let next = if next == u64::MAX { left } else { usize::try_from(next).map_err(|_| cut())? };
        let raw = usize::try_from(raw).map_err(|_| cut())?;
        if next > left || raw > next {
            return Err(cut());
        }
        let content = start + LEAD_IN_BYTES;
        if flags & META_DATA != 0 {
            let mut at = Cursor::new(&self.bytes[..content + next], order);
            at.at = content;
            self.objects(&mut at, flags & NEW_OBJECTS != 0).ok_or_else(|| damaged("its list of objects is damaged"))?;
        }
        if flags & RAW_DATA != 0 {
            self.raw(content + raw, next - raw, flags & INTERLEAVED != 0, order)
                .ok_or_else(|| damaged("its raw data is damaged"))?;
        }
        Ok(content + next)
    }

    fn objects(&mut self, at: &mut Cursor<'_>, are_new: bool) -> Option<()> {
        if are_new {
            self.active.clear();
        }
        for _ in 0..at.u32()? {
            let path = text(at)?;
            let index = match self.by_path.get(&path) {
                Some(index) => *index,
                None => {
                    self.channels.push(Channel { path: shown(&path), ..Channel::default() });
                    self.by_path.insert(path, self.channels.len() - 1);
                    self.channels.len() - 1
                }
            };
            let has_data = match at.u32()? {
                NO_DATA => false,
                SAME_DATA => self.channels[index].index.is_some(),
                _ => {
                    let kind = Kind::parse(at.u32()?)?;
                    let dimensions = at.u32()?;
                    let count = usize::try_from(at.u64()?).ok()?;
                    let size = match kind {
                        Kind::Text => usize::try_from(at.u64()?).ok()?,
                        _ => count.checked_mul(kind.size())?,
                    };
                    let channel = &mut self.channels[index];
                    let is_same = channel.index.is_none_or(|before| before.kind == kind);
                    if dimensions != 1 || !is_same {
                        return None;
                    }
                    channel.index = Some(Index { kind, count, size });
                    true
                }
            };
            let place = self.active.iter().position(|active| *active == index);
            match (has_data, place) {
                (true, None) => self.active.push(index),
                (false, Some(place)) => drop(self.active.remove(place)),
                _ => {}
            }
            for _ in 0..at.u32()? {
                let name = text(at)?;
                let value = property(at)?;
                let channel = &mut self.channels[index];
                match (name.as_str(), value) {
                    ("wf_increment", Property::Number(increment_s)) if increment_s > 0.0 => {
                        channel.increment_s = Some(increment_s);
                    }
                    ("wf_start_offset", Property::Number(offset_s)) => channel.offset_s = offset_s,
                    ("unit_string", Property::Text(unit)) if !unit.is_empty() => channel.unit = Some(unit),
                    _ => {}
                }
            }
        }
        Some(())
    }

    fn raw(&mut self, start: usize, size: usize, is_interleaved: bool, order: Order) -> Option<()> {
        let indices: Vec<(usize, Index)> =
            self.active.iter().filter_map(|index| Some((*index, self.channels[*index].index?))).collect();
        let chunk_bytes = indices.iter().try_fold(0_usize, |sum, (_, index)| sum.checked_add(index.size))?;
        if chunk_bytes == 0 {
            return Some(());
        }
        let chunks = size / chunk_bytes;
        let row_bytes: usize = indices.iter().map(|(_, index)| index.kind.size()).sum();
        let rows = indices.first()?.1.count;
        let is_even = |(_, index): &(usize, Index)| index.count == rows && index.kind != Kind::Text;
        if is_interleaved && !indices.iter().all(is_even) {
            return None;
        }
        let mut from = start;
        for (channel, index) in indices {
            let stride = if is_interleaved { row_bytes } else { index.kind.size() };
            let channel = &mut self.channels[channel];
            channel.runs.push(Run { start: from, count: index.count, stride, chunks, chunk_bytes, order });
            channel.len = channel.len.checked_add(index.count.checked_mul(chunks)?)?;
            from += if is_interleaved { index.kind.size() } else { index.size };
        }
        Some(())
    }
}

fn text(at: &mut Cursor<'_>) -> Option<String> {
    let length = at.index()?;
    Some(String::from_utf8_lossy(at.take(length)?).into_owned())
}

fn property(at: &mut Cursor<'_>) -> Option<Property> {
    Some(match Kind::parse(at.u32()?)? {
        Kind::Number(scalar) => Property::Number(scalar.read(at.take(scalar.size())?, at.order)?),
        Kind::Text => Property::Text(text(at)?),
        other => {
            at.take(other.size())?;
            Property::Other
        }
    })
}

/// The path `/'group'/'channel'` without its quotes.
fn shown(path: &str) -> String {
    let mut shown = String::with_capacity(path.len());
    let mut characters = path.chars().peekable();
    while let Some(character) = characters.next() {
        if character != '\'' {
            shown.push(character);
        } else if characters.next_if_eq(&'\'').is_some() {
            shown.push('\'');
        }
    }
    shown
}

impl Container for Tdms {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize) -> Result<Vec<f64>, Fault> {
        check_size(self.arrays[index].len(), &self.limits)?;
        let channel = match self.sources[index] {
            ArraySource::Values(channel) => &self.channels[channel],
            ArraySource::Clock(channel) => {
                let Channel { increment_s, offset_s, len, .. } = self.channels[channel];
                let increment_s = increment_s.unwrap_or(0.0);
                return Ok((0..len).map(|sample| offset_s + sample as f64 * increment_s).collect());
            }
        };
        let kind = channel.index.map_or(Kind::Other(0), |index| index.kind);
        let mut values = Vec::with_capacity(channel.len);
        for run in &channel.runs {
            for chunk in 0..run.chunks {
                let start = run.start + chunk * run.chunk_bytes;
                let value = |row: usize| kind.read(self.bytes.get(start + row * run.stride..)?, run.order);
                values.extend((0..run.count).map_while(value));
            }
        }
        if values.len() != channel.len {
            return Err(Format::Tdms.damaged("its raw data is cut off").into());
        }
        Ok(values)
    }
}
