//! LabVIEW's TDMS files, by National Instruments' "TDMS File Format Internal Structure": a signal `/group/channel` per
//! channel of numbers, and `time(/group/channel)` for a channel with a time increment. Raw data of DAQmx is rejected.
//!
//! A segment has a list of objects, which is new or continues the previous segment's list, and chunks of raw data. Each
//! chunk contains some values of every object.

use std::borrow::Cow;
use std::collections::HashMap;

use super::bytes::{Cursor, Order, Scalar};
use super::{Array, Container, Fault, Format};
use crate::error::Problem;
use crate::room::{Room, check_name, short};

const LEAD_IN_BYTES: usize = 28;

const META_DATA: u32 = 1 << 1;
const NEW_OBJECTS: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;

const NO_DATA: u32 = 0xffff_ffff;
const SAME_DATA: u32 = 0;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Number(Scalar),
    /// Seconds since 1904, and a fraction in 2^-64 s.
    Stamp,
    Text,
    /// The size of a value in bytes.
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

#[derive(Debug, Clone, Copy, PartialEq)]
struct Index {
    kind: Kind,
    count: usize,
    size: usize,
}

/// `count` values, `stride` bytes apart, in each of `chunks` chunks.
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
    entry: Option<u64>,
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
    unfinished: Option<String>,
}

impl Tdms {
    pub(super) fn open(bytes: Vec<u8>, room: &Room) -> Result<Self, Problem> {
        let mut reader = Reader {
            bytes: &bytes,
            room,
            channels: vec![],
            by_path: HashMap::new(),
            active: vec![],
            layout: Layout::default(),
            is_layout_new: true,
            entries: 0,
            unfinished: None,
        };
        let mut at = 0;
        while at < bytes.len() {
            at = reader.segment(at)?;
        }
        let (channels, unfinished) = (reader.channels, reader.unfinished);
        let (mut arrays, mut sources) = (vec![], vec![]);
        for (index, channel) in channels.iter().enumerate() {
            let is_number = channel.index.is_some_and(|index| matches!(index.kind, Kind::Number(_) | Kind::Stamp));
            if channel.len == 0 || !is_number {
                continue;
            }
            if channel.increment_s.is_some() {
                let array = Array::in_room(&format!("time({})", channel.path), vec![channel.len], room)?;
                arrays.push(Array { unit: Some("s".into()), ..array });
                sources.push(ArraySource::Clock(index));
            }
            let array = Array::in_room(&channel.path, vec![channel.len], room)?;
            arrays.push(Array { unit: channel.unit.clone(), ..array });
            sources.push(ArraySource::Values(index));
        }
        if !super::has_signals(&arrays) {
            return Err(Problem::no_signal(Format::Tdms, &[]));
        }
        Ok(Self { channels, arrays, sources, unfinished, bytes })
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    room: &'a Room,
    channels: Vec<Channel>,
    by_path: HashMap<String, usize>,
    /// The objects of the segment with raw data, in the order of their data. An object with another entry is no longer
    /// active at this place.
    active: Vec<(usize, u64)>,
    entries: u64,
    layout: Layout,
    is_layout_new: bool,
    unfinished: Option<String>,
}

#[derive(Debug, Default)]
struct Layout {
    indices: Vec<(usize, Index)>,
    chunk_bytes: usize,
    row_bytes: usize,
    is_even: bool,
}

impl Reader<'_> {
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
        // LabVIEW writes the length when the segment ends.
        if next == u64::MAX {
            self.unfinished = Some("its last segment has no end".to_owned());
        }
        let next = if next == u64::MAX { left } else { usize::try_from(next).map_err(|_| cut())? };
        let raw = usize::try_from(raw).map_err(|_| cut())?;
        if next > left || raw > next {
            return Err(cut());
        }
        let content = start + LEAD_IN_BYTES;
        if flags & META_DATA != 0 {
            let mut at = Cursor::new(&self.bytes[..content + next], order);
            at.at = content;
            let is_read = self.objects(&mut at, flags & NEW_OBJECTS != 0)?;
            is_read.ok_or_else(|| damaged("its list of objects is damaged"))?;
            if at.at != content + raw {
                return Err(damaged("the list of objects of a segment does not end where its raw data begins"));
            }
        }
        if flags & RAW_DATA != 0 {
            self.raw(&Raw {
                start: content + raw,
                size: next - raw,
                is_interleaved: flags & INTERLEAVED != 0,
                is_last: content + next == self.bytes.len(),
                order,
            })?;
        }
        Ok(content + next)
    }

    fn objects(&mut self, at: &mut Cursor<'_>, are_new: bool) -> Result<Option<()>, Problem> {
        if are_new {
            self.is_layout_new = true;
            self.active.drain(..).for_each(|(index, _)| self.channels[index].entry = None);
        }
        let Some(count) = at.u32() else { return Ok(None) };
        for _ in 0..count {
            let Some(path) = text(at) else { return Ok(None) };
            if !self.by_path.contains_key(&*path) {
                check_name(path.len())?;
                self.room.take(size_of::<Channel>() + path.len())?;
            }
            if self.object(at, &path).is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }

    fn object(&mut self, at: &mut Cursor<'_>, path: &str) -> Option<()> {
        let index = match self.by_path.get(path) {
            Some(index) => *index,
            None => {
                self.channels.push(Channel { path: shown(path), ..Channel::default() });
                self.by_path.insert(path.to_owned(), self.channels.len() - 1);
                self.channels.len() - 1
            }
        };
        let channel = &mut self.channels[index];
        let has_data = match at.u32()? {
            NO_DATA => false,
            SAME_DATA => channel.index.is_some(),
            _ => {
                let kind = Kind::parse(at.u32()?)?;
                let dimensions = at.u32()?;
                let count = usize::try_from(at.u64()?).ok()?;
                let size = match kind {
                    Kind::Text => usize::try_from(at.u64()?).ok()?,
                    _ => count.checked_mul(kind.size())?,
                };
                let is_same = channel.index.is_none_or(|before| before.kind == kind);
                if dimensions != 1 || !is_same {
                    return None;
                }
                let described = Some(Index { kind, count, size });
                self.is_layout_new |= channel.index != described;
                channel.index = described;
                true
            }
        };
        match (has_data, channel.entry) {
            (true, None) => {
                self.is_layout_new = true;
                self.entries += 1;
                channel.entry = Some(self.entries);
                self.active.push((index, self.entries));
            }
            (false, Some(_)) => {
                self.is_layout_new = true;
                channel.entry = None;
            }
            _ => {}
        }
        for _ in 0..at.u32()? {
            let name = text(at)?;
            let value = property(at)?;
            match (&*name, value) {
                ("wf_increment", Property::Number(increment_s)) if increment_s > 0.0 => {
                    channel.increment_s = Some(increment_s);
                }
                ("wf_start_offset", Property::Number(offset_s)) => channel.offset_s = offset_s,
                ("unit_string", Property::Text(unit)) if !unit.is_empty() => channel.unit = Some(unit),
                _ => {}
            }
        }
        Some(())
    }

    fn renew_layout(&mut self) -> Option<()> {
        let channels = &self.channels;
        self.active.retain(|(index, entry)| channels[*index].entry == Some(*entry));
        let index_of = |(channel, _): &(usize, u64)| Some((*channel, channels[*channel].index?));
        let indices: Vec<(usize, Index)> =
            self.active.iter().filter_map(index_of).filter(|(_, index)| index.size > 0).collect();
        let chunk_bytes = indices.iter().try_fold(0_usize, |sum, (_, index)| sum.checked_add(index.size))?;
        let row_bytes = indices.iter().map(|(_, index)| index.kind.size()).sum();
        let rows = indices.first().map_or(0, |(_, index)| index.count);
        let is_even = indices.iter().all(|(_, index)| index.count == rows && index.kind != Kind::Text);
        self.layout = Layout { indices, chunk_bytes, row_bytes, is_even };
        self.is_layout_new = false;
        Some(())
    }

    fn raw(&mut self, raw: &Raw) -> Result<(), Problem> {
        let damaged = || Format::Tdms.damaged("its raw data is damaged");
        if self.is_layout_new {
            // Every segment can change the list of objects.
            self.room.take(size_of::<(usize, Index)>() * self.active.len())?;
            self.renew_layout().ok_or_else(damaged)?;
        }
        let Layout { chunk_bytes, row_bytes, is_even, .. } = self.layout;
        if chunk_bytes == 0 {
            return match raw.size {
                0 => Ok(()),
                size => Err(Format::Tdms.damaged(format!("{size} bytes of raw data belong to no channel"))),
            };
        }
        let (chunks, rest) = (raw.size / chunk_bytes, raw.size % chunk_bytes);
        if rest > 0 && !raw.is_last {
            return Err(Format::Tdms.damaged(format!("{rest} bytes of raw data belong to no channel")));
        }
        if rest > 0 {
            let note = format!("the last {rest} bytes of raw data are left out, which are no whole chunk");
            self.unfinished = Some(note);
        }
        if chunks == 0 {
            return Ok(());
        }
        if raw.is_interleaved && !is_even {
            return Err(damaged());
        }
        let mut from = raw.start;
        for (channel, index) in &self.layout.indices {
            let stride = if raw.is_interleaved { row_bytes } else { index.kind.size() };
            if matches!(index.kind, Kind::Number(_) | Kind::Stamp) {
                self.room.take(size_of::<Run>())?;
                let channel = &mut self.channels[*channel];
                let run = Run { start: from, count: index.count, stride, chunks, chunk_bytes, order: raw.order };
                channel.runs.push(run);
                let count = index.count.checked_mul(chunks).and_then(|count| channel.len.checked_add(count));
                channel.len = count.ok_or_else(damaged)?;
            }
            from += if raw.is_interleaved { index.kind.size() } else { index.size };
        }
        Ok(())
    }
}

struct Raw {
    start: usize,
    size: usize,
    is_interleaved: bool,
    /// True for the last segment of the file, which can be cut off.
    is_last: bool,
    order: Order,
}

fn text<'a>(at: &mut Cursor<'a>) -> Option<Cow<'a, str>> {
    let length = at.index()?;
    Some(String::from_utf8_lossy(at.take(length)?))
}

fn property(at: &mut Cursor<'_>) -> Option<Property> {
    Some(match Kind::parse(at.u32()?)? {
        Kind::Number(scalar) => Property::Number(scalar.read(at.take(scalar.size())?, at.order)?),
        Kind::Text => Property::Text(short(&text(at)?)),
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

    fn unfinished(&self) -> Option<&str> {
        self.unfinished.as_deref()
    }

    fn values(&mut self, index: usize, _: &Room) -> Result<Vec<f64>, Fault> {
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
