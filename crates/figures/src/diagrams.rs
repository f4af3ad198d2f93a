//! Diagrams without data.

use trocar_document::figure::{
    AUGMENTED, Axis, COMPUTED, Color, Figure, GREY, GUIDE, Panel, Point, RUPTURE, Row, SKY, Stroke,
};

const HEIGHT: f64 = 60.0;
const LINE: f64 = 5.5;

struct Diagram {
    panel: Panel<'static>,
}

impl Diagram {
    fn new() -> Self {
        let axes = Panel::new(Axis::exact((0.0, 100.0), 0), "", Axis::exact((0.0, HEIGHT), 0), "");
        Self { panel: Panel { is_bare: true, ..axes } }
    }

    fn boxed(&mut self, (x, y): Point, (half_width, half_height): Point, text: &str, line: Stroke) {
        let (left, right) = (x - half_width, x + half_width);
        let (low, high) = (y - half_height, y + half_height);
        self.panel.curves.push((vec![(left, low), (right, low), (right, high), (left, high), (left, low)], line));
        let lines: Vec<&str> = text.lines().collect();
        for (index, words) in lines.iter().enumerate() {
            let above = 0.5 * (lines.len() as f64 - 1.0) - index as f64;
            self.note((x, y + LINE * above), words);
        }
    }

    fn arrow(&mut self, points: &[Point], line: Stroke) {
        self.panel.curves.push((points.to_vec(), line));
        let [.., (from_x, from_y), (x, y)] = *points else { return };
        let (along_x, along_y) = ((x - from_x).signum() * 2.0, (y - from_y).signum() * 3.0);
        let head = if x == from_x {
            vec![(x, y), (x - 1.2, y - along_y), (x + 1.2, y - along_y)]
        } else {
            vec![(x, y), (x - along_x, y - 1.8), (x - along_x, y + 1.8)]
        };
        self.panel.fills.push((head, line.color));
    }

    fn note(&mut self, at: Point, text: &str) {
        self.panel.notes.push((at, text.to_owned()));
    }

    fn figure(self, name: &str) -> Figure<'static> {
        Figure { name: name.to_owned(), legend: vec![], rows: vec![Row::of(150.0, self.panel)] }
    }
}

/// Draws the principle of the detection, from the force and its estimate to the alarm, as in figure 10 of the paper.
pub fn principle() -> Figure<'static> {
    const HALF: Point = (21.0, 6.0);
    let mut diagram = Diagram::new();
    for (at, text) in [
        ((22.0, 52.0), "needle in the tissue"),
        ((22.0, 8.0), "estimate K p + B v"),
        ((78.0, 52.0), "residual e"),
        ((78.0, 30.0), "distance s = e²"),
        ((78.0, 8.0), "CUSUM: alarm if g > γ"),
    ] {
        diagram.boxed(at, HALF, text, COMPUTED);
    }
    // The estimate reaches the residual around the middle.
    let arrows: [&[Point]; 5] = [
        &[(22.0, 46.0), (22.0, 14.0)],
        &[(43.0, 54.0), (57.0, 54.0)],
        &[(43.0, 8.0), (50.0, 8.0), (50.0, 50.0), (57.0, 50.0)],
        &[(78.0, 46.0), (78.0, 36.0)],
        &[(78.0, 24.0), (78.0, 14.0)],
    ];
    arrows.into_iter().for_each(|arrow| diagram.arrow(arrow, COMPUTED));
    for (at, text) in [((30.5, 30.0), "p, v, f"), ((50.0, 57.5), "force f"), ((62.5, 41.0), "estimated f")] {
        diagram.note(at, text);
    }
    diagram.figure("Detection by a model of the force")
}

/// Draws the force-position controller with the adaptation at a rupture, as in figure 14 of the paper: the adaptation
/// in the colour of augmented runs.
pub fn augmented_controller() -> Figure<'static> {
    const HALF: Point = (10.5, 8.0);
    let mut diagram = Diagram::new();
    for (at, text, line) in [
        ((11.0, 48.0), "user", COMPUTED),
        ((37.0, 48.0), "master and\ncontroller", COMPUTED),
        ((63.0, 48.0), "hold during\nan event", AUGMENTED),
        ((89.0, 48.0), "slave and\ncontroller", COMPUTED),
        ((89.0, 10.0), "tissue", COMPUTED),
        ((63.0, 10.0), "rupture\ndetection", AUGMENTED),
        ((37.0, 10.0), "force law\nin an event", AUGMENTED),
    ] {
        diagram.boxed(at, HALF, text, line);
    }
    let arrows: [(&[Point], Stroke); 10] = [
        (&[(21.5, 51.0), (26.5, 51.0)], COMPUTED),
        (&[(26.5, 45.0), (21.5, 45.0)], COMPUTED),
        (&[(47.5, 48.0), (52.5, 48.0)], COMPUTED),
        (&[(73.5, 48.0), (78.5, 48.0)], COMPUTED),
        (&[(89.0, 40.0), (89.0, 18.0)], COMPUTED),
        (&[(78.5, 10.0), (73.5, 10.0)], COMPUTED),
        (&[(52.5, 10.0), (47.5, 10.0)], AUGMENTED),
        (&[(63.0, 18.0), (63.0, 40.0)], AUGMENTED),
        (&[(37.0, 18.0), (37.0, 40.0)], COMPUTED),
        (&[(11.0, 26.0), (11.0, 40.0)], COMPUTED),
    ];
    arrows.into_iter().for_each(|(arrow, line)| diagram.arrow(arrow, line));
    diagram.arrow(&[(76.0, 10.0), (76.0, 26.0), (43.0, 26.0), (43.0, 18.0)], COMPUTED);
    for (at, text) in [
        ((11.0, 22.0), "X_h^d"),
        ((24.0, 55.0), "F_h"),
        ((24.0, 40.5), "X_h"),
        ((50.0, 52.5), "X_h"),
        ((76.0, 52.5), "X_ref"),
        ((92.5, 29.0), "X_e"),
        ((76.0, 5.0), "F_e"),
        ((50.0, 5.0), "alarm"),
        ((67.5, 33.0), "alarm"),
        ((33.0, 29.0), "F_h^d"),
    ] {
        diagram.note(at, text);
    }
    diagram.figure("Force-position controller with adaptation at a rupture")
}

const TISSUE_COLOR: Color = SKY.pale(0.45);
const SURFACE: f64 = 34.0;
const TOP: f64 = 70.0;
const HALF_WIDTH: f64 = 15.5;
const NEEDLE: f64 = 0.8;
/// Width of the deformation of the surface.
const SPREAD: f64 = 5.0;

/// Draws the three phases of an insertion into one layer, not to scale, as in figure 1 of the paper.
pub fn insertion_phases() -> Figure<'static> {
    let axes = Panel::new(Axis::exact((0.0, 100.0), 0), "", Axis::exact((0.0, 80.0), 0), "");
    let mut panel = Panel { is_bare: true, ..axes };
    for (middle, name, surface, tip, direction) in [
        (16.0, "1: deforms the tissue", 14.0, 14.0, -1.0),
        (50.0, "2: penetrates it", 6.0, 24.0, -1.0),
        (84.0, "3: is extracted", -7.0, 8.0, 1.0),
    ] {
        let (left, right) = (middle - HALF_WIDTH, middle + HALF_WIDTH);
        let line: Vec<Point> = (0..=100)
            .map(|step| {
                let x = left + (right - left) * f64::from(step) / 100.0;
                (x, SURFACE - surface * (-((x - middle) / SPREAD).abs()).exp())
            })
            .collect();
        let mut tissue = vec![(left, 4.0)];
        tissue.extend(&line);
        tissue.push((right, 4.0));
        panel.fills.push((tissue, TISSUE_COLOR));
        let (point, shoulder) = (SURFACE - tip, SURFACE - tip + 5.0);
        let needle = [
            (middle, point),
            (middle - NEEDLE, shoulder),
            (middle - NEEDLE, TOP),
            (middle + NEEDLE, TOP),
            (middle + NEEDLE, shoulder),
        ];
        panel.fills.push((needle.into(), GREY));
        panel.curves.push((line, COMPUTED));
        panel.curves.push((vec![(left, SURFACE), (right, SURFACE)], RUPTURE));
        let (x, from, to) = (middle + 5.0, 57.0 - 8.0 * direction, 57.0 + 8.0 * direction);
        panel.curves.push((vec![(x, from), (x, to - 3.0 * direction)], GUIDE));
        panel.fills.push((vec![(x, to), (x - 0.9, to - 5.0 * direction), (x + 0.9, to - 5.0 * direction)], GREY));
        panel.notes.push(((middle, 77.0), name.to_owned()));
    }
    Figure {
        name: "Insertion of a needle into one layer".to_owned(),
        legend: vec![],
        rows: vec![Row::of(150.0, panel)],
    }
}
