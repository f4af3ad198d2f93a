//! The used letters of the typeface are embedded.

use std::collections::BTreeMap;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{CidFontType, FontFlags, LineCapStyle, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str};
use plotters_backend::BackendCoord;
use subsetter::GlyphRemapper;
use ttf_parser::GlyphId;

use super::canvas::{Backend, Canvas, Rgb};
use super::fonts::{Placed, Typeface, typeface};
use super::layout::Sheet;
use super::{DrawError, UNITS};

const IDENTITY: SystemInfo<'_> = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// The objects of the document; five per font from [`FIRST_FONT`] on.
const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const FIRST_FONT: i32 = 5;
const REFS_PER_FONT: i32 = 5;

pub(super) fn document(sheet: &Sheet<'_>) -> Result<Vec<u8>, DrawError> {
    let mut page = PdfPage::new(sheet.size());
    sheet.draw_on(Backend { canvas: &mut page, size: sheet.size() })?;
    let PdfPage { content, fonts, .. } = page;
    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let used: Vec<(&Embedded, i32)> = fonts
        .iter()
        .filter(|font| !font.letters.is_empty())
        .zip((FIRST_FONT..).step_by(REFS_PER_FONT as usize))
        .collect();
    let mut page = pdf.page(PAGE);
    page.parent(PAGES).media_box(Rect::new(0.0, 0.0, sheet.width as f32, sheet.height as f32)).contents(CONTENT);
    let mut resources = page.resources();
    let mut names = resources.fonts();
    for (font, first) in &used {
        names.pair(font.resource, Ref::new(*first));
    }
    names.finish();
    resources.finish();
    page.finish();
    pdf.stream(CONTENT, &deflated(&content.finish())?).filter(Filter::FlateDecode);
    for (font, first) in used {
        font.write(&mut pdf, first)?;
    }
    Ok(pdf.finish())
}

struct PdfPage {
    content: Content,
    fonts: [Embedded; 2],
    height: f32,
}

impl PdfPage {
    fn new((_, height): (u32, u32)) -> Self {
        let fonts = [false, true].map(|is_bold| Embedded {
            typeface: typeface(is_bold),
            resource: if is_bold { Name(b"B") } else { Name(b"R") },
            glyphs: GlyphRemapper::new(),
            letters: BTreeMap::new(),
        });
        let mut content = Content::new();
        content.set_line_join(LineJoinStyle::RoundJoin).set_line_cap(LineCapStyle::RoundCap);
        Self { content, fonts, height: height as f32 }
    }

    /// A position on the page in points, upwards from its lower left corner.
    fn place(&self, (x, y): (f32, f32)) -> (f32, f32) {
        (x / UNITS as f32, (self.height - y) / UNITS as f32)
    }

    fn trace(&mut self, points: &[BackendCoord]) {
        for (index, at) in points.iter().enumerate() {
            let (x, y) = self.place((at.0 as f32, at.1 as f32));
            if index == 0 {
                self.content.move_to(x, y)
            } else {
                self.content.line_to(x, y)
            };
        }
    }
}

impl Canvas for PdfPage {
    fn stroke(&mut self, line: &[BackendCoord], width: u32, color: Rgb) {
        let [red, green, blue] = channels(color);
        self.content.set_stroke_rgb(red, green, blue).set_line_width(width as f32 / UNITS as f32);
        self.trace(line);
        self.content.stroke();
    }

    fn fill(&mut self, outline: &[BackendCoord], color: Rgb, _: bool) {
        let [red, green, blue] = channels(color);
        self.content.set_fill_rgb(red, green, blue);
        self.trace(outline);
        self.content.fill_nonzero();
    }

    fn text(&mut self, text: &str, placed: &Placed) {
        let (x, y) = self.place(placed.start);
        let [red, green, blue] = channels(placed.color);
        let font = &mut self.fonts[usize::from(placed.is_bold)];
        let upright = [0.0, 1.0, -1.0, 0.0, x, y];
        self.content.begin_text().set_fill_rgb(red, green, blue).set_font(font.resource, placed.em / UNITS as f32);
        self.content.set_text_matrix(if placed.is_upright { upright } else { [1.0, 0.0, 0.0, 1.0, x, y] });
        self.content.show(Str(&font.encode(text)));
        self.content.end_text();
    }
}

struct Embedded {
    typeface: &'static Typeface,
    resource: Name<'static>,
    glyphs: GlyphRemapper,
    /// The letter of each glyph in the subset, and its advance relative to the em.
    letters: BTreeMap<u16, (char, f64)>,
}

impl Embedded {
    fn encode(&mut self, text: &str) -> Vec<u8> {
        let mut bytes = vec![];
        for letter in text.chars() {
            let glyph = self.typeface.glyph(letter);
            let place = self.glyphs.remap(glyph.0);
            self.letters.insert(place, (letter, self.typeface.advance(GlyphId(glyph.0))));
            bytes.extend(place.to_be_bytes());
        }
        bytes
    }

    fn write(&self, pdf: &mut Pdf, first: i32) -> Result<(), DrawError> {
        let [font, descendant, descriptor, file, map] = [0, 1, 2, 3, 4].map(|offset| Ref::new(first + offset));
        let subset = subsetter::subset(self.typeface.data, 0, &self.glyphs).map_err(|_| DrawError::Font)?;
        // The six letters before the name mark a subset.
        let name = format!("TROCAR+{}", self.typeface.name);
        let name = Name(name.as_bytes());
        pdf.type0_font(font)
            .base_font(name)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(descendant)
            .to_unicode(map);
        let mut cid = pdf.cid_font(descendant);
        cid.subtype(CidFontType::Type2)
            .base_font(name)
            .system_info(IDENTITY)
            .font_descriptor(descriptor)
            .default_width(0.0)
            .cid_to_gid_map_predefined(Name(b"Identity"));
        let mut widths = cid.widths();
        for (glyph, (_, advance)) in &self.letters {
            widths.consecutive(*glyph, [(1e3 * advance) as f32]);
        }
        widths.finish();
        cid.finish();
        let face = &self.typeface.face;
        let thousandths = |units: i16| 1e3 * f32::from(units) / f32::from(face.units_per_em());
        let bounds = face.global_bounding_box();
        let [left, bottom, right, top] = [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max].map(thousandths);
        pdf.font_descriptor(descriptor)
            .name(name)
            .flags(FontFlags::SYMBOLIC)
            .bbox(Rect::new(left, bottom, right, top))
            .italic_angle(0.0)
            .ascent(thousandths(face.ascender()))
            .descent(thousandths(face.descender()))
            .cap_height(thousandths(face.capital_height().unwrap_or(face.ascender())))
            .stem_v(if face.is_bold() { 140.0 } else { 80.0 })
            .font_file2(file);
        pdf.stream(file, &deflated(&subset)?)
            .filter(Filter::FlateDecode)
            .pair(Name(b"Length1"), i32::try_from(subset.len()).unwrap_or(i32::MAX));
        let mut unicode = UnicodeCmap::new(Name(b"Custom"), IDENTITY);
        for (glyph, (letter, _)) in &self.letters {
            unicode.pair(*glyph, *letter);
        }
        pdf.cmap(map, &deflated(&unicode.finish())?).filter(Filter::FlateDecode);
        Ok(())
    }
}

fn channels((red, green, blue): Rgb) -> [f32; 3] {
    [red, green, blue].map(|channel| f32::from(channel) / 255.0)
}

fn deflated(bytes: &[u8]) -> Result<Vec<u8>, DrawError> {
    use std::io::Write as _;
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).map_err(DrawError::Deflate)
}
