use std::convert::Infallible;

use plotters::prelude::DrawingBackend;
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind};

use super::fonts::Placed;

pub(crate) type Rgb = (u8, u8, u8);

pub(crate) trait Canvas {
    /// Draws a line with round ends and joins. Both ends may be at the same point.
    fn stroke(&mut self, line: &[BackendCoord], width: u32, color: Rgb);

    /// Fills an outline. An upright rectangle is not smoothed, to avoid seams between neighbours.
    fn fill(&mut self, outline: &[BackendCoord], color: Rgb, is_smooth: bool);

    fn text(&mut self, text: &str, placed: &Placed);
}

pub(crate) struct Backend<'a, C> {
    pub(crate) canvas: &'a mut C,
    pub(crate) size: (u32, u32),
}

type Done = Result<(), DrawingErrorKind<Infallible>>;

impl<C: Canvas> DrawingBackend for Backend<'_, C> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Done {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Done {
        let outline = [from, (to.0, from.1), to, (from.0, to.1), from];
        if !fill {
            return self.draw_path(outline, style);
        }
        self.canvas.fill(&outline, style.color().rgb, false);
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, line: I, style: &S) -> Done {
        self.canvas.stroke(&line.into_iter().collect::<Vec<_>>(), style.stroke_width(), style.color().rgb);
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, outline: I, style: &S) -> Done {
        self.canvas.fill(&outline.into_iter().collect::<Vec<_>>(), style.color().rgb, true);
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, centre: BackendCoord, radius: u32, style: &S, _: bool) -> Done {
        self.canvas.stroke(&[centre; 2], 2 * radius, style.color().rgb);
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        self.canvas.text(text, &Placed::of(text, style, at));
        Ok(())
    }
}
