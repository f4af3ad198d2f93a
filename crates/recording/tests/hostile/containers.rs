//! Binary formats.

use std::io::Write;

use super::{answers, refused};

/// An element of MATLAB's format.
fn element(kind: u32, content: &[u8]) -> Vec<u8> {
    let padding = vec![0; content.len().next_multiple_of(8) - content.len()];
    [&kind.to_le_bytes()[..], &(content.len() as u32).to_le_bytes(), content, &padding].concat()
}

pub(crate) fn matrix(class: u32, dims: [i32; 2], name: &[u8], rest: &[u8]) -> Vec<u8> {
    let flags = element(6, &[class.to_le_bytes(), [0; 4]].concat());
    let dims = element(5, &dims.map(i32::to_le_bytes).concat());
    element(14, &[flags, dims, element(1, name), rest.to_vec()].concat())
}

pub(crate) fn leaf(name: &[u8]) -> Vec<u8> {
    matrix(6, [1, 2], name, &element(9, &[1.0_f64, 2.0].map(f64::to_le_bytes).concat()))
}

pub(crate) fn packed(content: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::ZlibEncoder::new(vec![], flate2::Compression::fast());
    packed.write_all(content).expect("memory");
    let packed = packed.finish().expect("memory");
    [&15_u32.to_le_bytes()[..], &(packed.len() as u32).to_le_bytes(), &packed].concat()
}

pub(crate) fn matlab(elements: &[u8]) -> Vec<u8> {
    let mut header = b"MATLAB 5.0 MAT-file".to_vec();
    header.resize(124, b' ');
    [&header[..], &[0, 1], b"IM", elements].concat()
}

#[test]
fn matlab_multiplies_neither_names_nor_bytes() {
    let leaves = leaf(b"").repeat(20_000);
    let names = matlab(&packed(&matrix(1, [1, 20_000], &b"a".repeat(200_000), &leaves)));
    refused("names.mat", &names, &["a name of 200000 bytes"]);
    let cells = matlab(&packed(&matrix(1, [1, 20_000], b"a", &leaves)));
    refused("cells.mat", &cells, &["recording.max_bytes"]);
    let zeros = packed(&matrix(4, [1, 30_000_000], b"t", &element(16, &vec![0; 30_000_000])));
    refused("inflate.mat", &matlab(&zeros.repeat(40)), &["recording.max_bytes"]);
    let deep = (0..2000).fold(leaf(b"a"), |inner, _| matrix(1, [1, 1], b"a", &inner));
    refused("deep.mat", &matlab(&deep), &["at depth 33"]);
    refused("dims.mat", &matlab(&matrix(6, [i32::MAX; 2], b"a", &element(9, &[0; 16]))), &["contradict"]);
}

#[test]
fn many_small_arrays_are_refused() {
    let arrays: Vec<u8> = (0..30_000).flat_map(|k: u32| leaf(format!("a{k}").as_bytes())).collect();
    refused("arrays.mat", &matlab(&arrays), &["recording.max_bytes"]);
}

pub(crate) fn lead_in(flags: u32, following: u64, raw: u64) -> Vec<u8> {
    [
        b"TDSm".to_vec(),
        flags.to_le_bytes().to_vec(),
        vec![0x69, 0x12, 0, 0],
        following.to_le_bytes().to_vec(),
        raw.to_le_bytes().to_vec(),
    ]
    .concat()
}

/// A list of channels of bytes, each with `values` values in a chunk.
pub(crate) fn channels(count: u32, values: u64) -> Vec<u8> {
    let channel = |index: u32| {
        let path = format!("/'g'/'{index}'");
        let words = [20_u32, 5, 1].iter().flat_map(|word| word.to_le_bytes());
        let mut all = (path.len() as u32).to_le_bytes().to_vec();
        all.extend(path.bytes().chain(words).chain(values.to_le_bytes()).chain([0; 4]));
        all
    };
    count.to_le_bytes().into_iter().chain((0..count).flat_map(channel)).collect()
}

pub(crate) fn segment(flags: u32, list: &[u8], raw: &[u8]) -> Vec<u8> {
    [&lead_in(flags, (list.len() + raw.len()) as u64, list.len() as u64), list, raw].concat()
}

#[test]
fn segments_and_channels_of_tdms_take_linear_time() {
    let first = segment(0x0e, &channels(1000, 1), &[1; 2000]);
    let messages = answers("empty.tdms", &[first.clone(), lead_in(0x08, 0, 0).repeat(50_000)].concat());
    assert_eq!(messages.len(), 1, "only the columns are missing: {messages:?}");
    refused(
        "data.tdms",
        &[first.clone(), segment(0x08, &[], &[1; 1000]).repeat(500)].concat(),
        &["recording.max_bytes"],
    );
    // Every list changes the number of values of the first channel.
    let lists: Vec<u8> = (0..30_000).flat_map(|k| segment(0x0a, &channels(1, 2 + k % 2), &[])).collect();
    refused("lists.tdms", &[first, lists].concat(), &["recording.max_bytes"]);
    refused("channels.tdms", &segment(0x0e, &channels(50_000, 1), &[1; 100_000]), &["recording.max_bytes"]);
}

#[test]
fn bytes_of_tdms_that_belong_to_nothing_are_errors() {
    let list = channels(2, 5);
    refused(
        "leftover.tdms",
        &segment(0x0e, &[&list[..], &[0; 8]].concat(), &[1; 20]),
        &["does not end where its raw data begins"],
    );
    refused("raw.tdms", &segment(0x0e, &channels(0, 0), &[1; 20]), &["20 bytes of raw data belong to no channel"]);
    let cut = [segment(0x0e, &list, &[1; 23]), segment(0x08, &[], &[1; 20])].concat();
    refused("middle.tdms", &cut, &["3 bytes of raw data belong to no channel"]);
}

fn record(code: u8, content: &[u8]) -> Vec<u8> {
    [&[code][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

pub(crate) fn log(records: &[u8]) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x89MCAP0\r\n";
    [MAGIC, &record(1, &[0; 8]), records, &record(2, &[0; 20]), MAGIC].concat()
}

pub(crate) fn channel(encoding: &str, schema: Option<(&str, &str)>) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let of_schema = schema
        .map(|(name, definition)| record(3, &[&[1, 0][..], &text(name), &text("ros2msg"), &text(definition)].concat()));
    let id = u16::from(schema.is_some()).to_le_bytes();
    let channel = record(4, &[&[1, 0][..], &id, &text("/r"), &text(encoding), &text("")].concat());
    [of_schema.unwrap_or_default(), channel].concat()
}

pub(crate) fn message(time_ns: u64, data: &[u8]) -> Vec<u8> {
    record(5, &[&[1, 0, 0, 0, 0, 0][..], &time_ns.to_le_bytes(), &time_ns.to_le_bytes(), data].concat())
}

pub(crate) fn chunk(compression: &str, plain: u64, records: &[u8]) -> Vec<u8> {
    let head = [&[0; 16][..], &plain.to_le_bytes(), &[0; 4], &(compression.len() as u32).to_le_bytes()].concat();
    record(6, &[&head[..], compression.as_bytes(), &(records.len() as u64).to_le_bytes(), records].concat())
}

#[test]
fn logs_multiply_neither_names_nor_bytes() {
    let inner: Vec<String> = (0..1000).map(|k| format!("\"a{k}\":1")).collect();
    let key = format!("{{\"{}\":{{{}}}}}", "K".repeat(200_000), inner.join(","));
    let keys = [channel("json", None), message(1, key.as_bytes()), message(2, key.as_bytes())].concat();
    refused("key.mcap", &log(&keys), &["a name of 200001 bytes"]);
    let nested = "B[64] b\n===\nMSG: lab/B\nC[64] c\n===\nMSG: lab/C\nuint8[64] d\n";
    let data = vec![0; 4 + 64 * 64 * 64];
    let names = [channel("cdr", Some(("lab/A", nested))), message(1, &data), message(2, &data)].concat();
    refused("names.mcap", &log(&names), &["recording.max_bytes"]);
    let mut frame = lz4_flex::frame::FrameEncoder::new(vec![]);
    frame.write_all(&vec![0; 30_000_000]).expect("memory");
    let frame = frame.finish().expect("memory");
    refused("bombs.mcap", &log(&chunk("lz4", 30_000_000, &frame).repeat(20)), &["recording.max_bytes"]);
    refused("claims.mcap", &log(&chunk("lz4", 1 << 60, &frame[..1000])), &["cannot be read", "recording.max_bytes"]);
}

#[test]
fn a_changed_bit_of_a_log_with_a_checksum_is_an_error() {
    let messages: Vec<u8> = (0..100).flat_map(|k| message(k, format!("{{\"x\":{k}.5}}").as_bytes())).collect();
    let records = [channel("json", None), messages].concat();
    let mut sum = flate2::Crc::new();
    sum.update(&records);
    let mut summed = chunk("", records.len() as u64, &records);
    summed[9 + 24..9 + 28].copy_from_slice(&sum.sum().to_le_bytes());
    let good = log(&summed);
    assert_eq!(answers("good.mcap", &good).len(), 1, "only the columns are missing");
    for place in (60..good.len() - 60).step_by(151) {
        let mut damaged = good.clone();
        damaged[place] ^= 1 << (place % 8);
        refused("damaged.mcap", &damaged, &["cannot be read"]);
    }
}

pub(crate) fn numpy(header: &str, data: &[u8]) -> Vec<u8> {
    [b"\x93NUMPY\x02\0", &(header.len() as u32).to_le_bytes()[..], header.as_bytes(), data].concat()
}

pub(crate) fn archive(entries: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(vec![]));
    for (name, content) in entries {
        archive.start_file(name.as_str(), zip::write::SimpleFileOptions::default()).expect("an entry");
        archive.write_all(content).expect("memory");
    }
    archive.finish().expect("memory").into_inner()
}

#[test]
fn arrays_of_numpy_are_within_the_limits() {
    let huge = "{'descr':'<f8','fortran_order':False,'shape':(4000000000,4000000000,),}\n";
    refused("huge.npy", &numpy(huge, &[0; 100]), &["cannot be read"]);
    let deep =
        format!("{{'descr':'<f8','fortran_order':False,'shape':{}{},}}\n", "(".repeat(200_000), ")".repeat(200_000));
    refused("deep.npy", &numpy(&deep, &[]), &["nested too deeply"]);
    let zeros = numpy("{'descr':'|i1','fortran_order':False,'shape':(4000000,),}\n", &vec![0; 4_000_000]);
    let bombs: Vec<(String, Vec<u8>)> = (0..10).map(|k| (format!("a{k}.npy"), zeros.clone())).collect();
    refused("bombs.npz", &archive(&bombs), &["recording.max_bytes"]);
}

/// A file of Parquet without rows, whose schema is groups within one another.
#[test]
fn groups_of_parquet_are_not_deep() {
    // The version, and a list of 80,000 elements: the root, groups of one part, and a column of numbers.
    let mut footer = b"\x15\x02\x19\xfc\x80\xf1\x04\x48\x01g\x15\x02\0".to_vec();
    (0..79_998).for_each(|_| footer.extend(*b"\x35\0\x18\x01g\x15\x02\0"));
    footer.extend(*b"\x15\x0a\x25\0\x18\x01x\0");
    footer.extend(*b"\x16\0\x19\x0c\0");
    let file = [b"PAR1", &footer[..], &(footer.len() as u32).to_le_bytes(), b"PAR1"].concat();
    refused("deep.parquet", &file, &["at depth 33"]);
    refused(
        "footer.parquet",
        &[b"PAR1", &[0; 5 << 20][..], &(5_u32 << 20).to_le_bytes(), b"PAR1"].concat(),
        &["a footer of"],
    );
}

/// A spreadsheet with the same sheet `sheets` times, whose table of texts has attributes.
pub(crate) fn book(sheets: usize, texts: &str, cells: &str) -> Vec<u8> {
    const SHEETS: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    const RELATIONS: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006/relationships";
    let relations = |rows: &str| format!("<Relationships xmlns=\"{PACKAGE}\">{rows}</Relationships>");
    let relation = |id: &str, kind: &str, to: &str| {
        format!("<Relationship Id=\"{id}\" Type=\"{RELATIONS}/{kind}\" Target=\"{to}\"/>")
    };
    let sheets: String = (0..sheets).map(|k| format!("<sheet name=\"s{k}\" sheetId=\"{k}\" r:id=\"a\"/>")).collect();
    let entry = |name: &str, content: String| (name.to_owned(), content.into_bytes());
    archive(&[
        entry("[Content_Types].xml", "<Types/>".into()),
        entry("_rels/.rels", relations(&relation("a", "officeDocument", "xl/workbook.xml"))),
        entry(
            "xl/workbook.xml",
            format!("<workbook xmlns=\"{SHEETS}\" xmlns:r=\"{RELATIONS}\"><sheets>{sheets}</sheets></workbook>"),
        ),
        entry(
            "xl/_rels/workbook.xml.rels",
            relations(
                &(relation("a", "worksheet", "worksheets/a.xml")
                    + &relation("b", "sharedStrings", "sharedStrings.xml")),
            ),
        ),
        entry("xl/sharedStrings.xml", format!("<sst xmlns=\"{SHEETS}\" {texts}><si><t>a</t></si></sst>")),
        entry(
            "xl/worksheets/a.xml",
            format!("<worksheet xmlns=\"{SHEETS}\"><sheetData>{cells}</sheetData></worksheet>"),
        ),
    ])
}

#[test]
fn parts_of_spreadsheets_are_within_the_limits() {
    let cell = "<row><c><v>1</v></c></row>";
    assert_eq!(
        answers("good.xlsx", &book(1, "uniqueCount=\"1\"", &cell.repeat(3))).len(),
        1,
        "only the columns are missing"
    );
    refused("texts.xlsx", &book(1, "uniqueCount=\"4000000000\"", cell), &["states more texts"]);
    answers("attributes.xlsx", &book(1, &"a=\"\" ".repeat(50_000), cell));
    refused("sheets.xlsx", &book(5000, "", &cell.repeat(1000)), &["recording.max_bytes"]);
    refused(
        "cells.xlsx",
        &book(1, "", &format!("<row>{}</row>", "<c><v>1</v></c>".repeat(16_000)).repeat(20)),
        &["recording.max_bytes"],
    );
}
