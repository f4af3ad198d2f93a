//! An animation as the shapes of each frame, which pages and animated pictures only place.

use serde::{Serialize, Serializer};
use serde_json::{Value as Json, json};

use crate::{Few, Fine};

#[derive(Clone, Debug, Serialize)]
pub struct Animation {
    pub title: String,
    /// In s.
    pub time_s: Vec<Fine>,
    pub clocks: Vec<String>,
    /// The animation plays around it.
    #[serde(skip)]
    pub origin_s: f64,
    /// Slowdown relative to the run.
    pub slowness: f64,
    pub still: usize,
    pub panels: Vec<Panel>,
    #[serde(skip)]
    pub pictures: Vec<Drawing>,
}

/// Each list has one value per frame.
#[derive(Clone, Debug, Serialize)]
pub struct Panel {
    pub name: String,
    /// `classical` or `augmented`.
    pub scheme: &'static str,
    pub note: String,
    pub alt: String,
    pub states: Vec<&'static str>,
    /// On a wide and on a narrow page.
    pub drawings: Vec<Drawing>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    fn word(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

/// Each frame has the same shapes in the same order; they may exceed the drawing.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    pub size: (f64, f64),
    pub frames: Vec<Vec<Shape>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// An even layer of the tissue, from the top down.
    TissueEven,
    TissueOdd,
    Tear,
    Label,
    Level,
    Bracket,
    Overshoot,
    Needle,
    Clamp,
    Brake,
    Barrier,
    Rail,
    Hand,
    Grip,
    Vibration,
    Track,
    /// The felt force if it pushes.
    Force,
    /// The felt force if it pulls.
    Pull,
    Newtons,
    /// The scale in millimetres.
    Ruler,
}

/// Without points it is hidden.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    pub role: Role,
    pub x: Vec<f64>,
    /// From the top.
    pub y: Vec<f64>,
    pub text: Option<(Anchor, String)>,
}

impl Shape {
    pub fn new<const N: usize>(role: Role, points: [(f64, f64); N]) -> Self {
        let (x, y) = points.into_iter().unzip();
        Self { role, x, y, text: None }
    }

    pub fn rectangle(role: Role, (left, right): (f64, f64), (top, bottom): (f64, f64)) -> Self {
        Self::new(role, [(left, top), (right, top), (right, bottom), (left, bottom)])
    }

    pub fn text(role: Role, at: (f64, f64), anchor: Anchor, text: impl Into<String>) -> Self {
        Self { text: Some((anchor, text.into())), ..Self::new(role, [at]) }
    }

    pub fn shown_if(self, is_shown: bool) -> Self {
        if is_shown { self } else { Self { x: vec![], y: vec![], ..self } }
    }

    fn kind(&self) -> &'static str {
        match self.role {
            _ if self.text.is_some() => "text",
            Role::Level | Role::Barrier | Role::Bracket | Role::Rail | Role::Grip | Role::Vibration | Role::Ruler => {
                "polyline"
            }
            Role::TissueEven
            | Role::TissueOdd
            | Role::Tear
            | Role::Label
            | Role::Overshoot
            | Role::Needle
            | Role::Clamp
            | Role::Brake
            | Role::Hand
            | Role::Track
            | Role::Force
            | Role::Pull
            | Role::Newtons => "polygon",
        }
    }
}

impl Drawing {
    /// `size`, and each of the `shapes`: `kind`, `role`, positions `x` and `states`. A state has its first frame, the
    /// positions y from then on (empty: hidden), and the text.
    pub fn description(&self) -> Json {
        let Some((first, frames)) = self.frames.split_first() else { return Json::Null };
        let mut tracks: Vec<Json> = first.iter().map(placed).collect();
        let seen = |shape: &Shape| (shape.y.iter().copied().map(tenth).collect::<Vec<f64>>(), shape.text.clone());
        let mut last: Vec<_> = first.iter().map(seen).collect();
        for (frame, shapes) in (1..).zip(frames) {
            for ((track, shape), last) in tracks.iter_mut().zip(shapes).zip(&mut last) {
                if !shape.x.is_empty() && track["x"].as_array().is_some_and(Vec::is_empty) {
                    track["x"] = json!(tenths(&shape.x));
                }
                // Changes below the drawn resolution, such as the end of a decay, need no state.
                let now = seen(shape);
                if let (true, Some(states)) = (now != *last, track["states"].as_array_mut()) {
                    *last = now;
                    let text = shape.text.as_ref().map(|(_, text)| text);
                    states.push(if text.is_some() {
                        json!([frame, tenths(&shape.y), text])
                    } else {
                        json!([frame, tenths(&shape.y)])
                    });
                }
            }
        }
        json!({ "size": [self.size.0, self.size.1], "shapes": tracks })
    }
}

impl Serialize for Drawing {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.description().serialize(serializer)
    }
}

fn tenth(place: f64) -> f64 {
    (10.0 * place).round() / 10.0 + 0.0
}

fn tenths(places: &[f64]) -> Vec<Few> {
    places.iter().map(|place| Few(tenth(*place))).collect()
}

fn placed(shape: &Shape) -> Json {
    let (anchor, text) = shape.text.as_ref().map_or((None, None), |(anchor, text)| (Some(anchor.word()), Some(text)));
    json!({
        "kind": shape.kind(),
        "role": shape.role,
        "anchor": anchor,
        "x": tenths(&shape.x),
        "states": [[0, tenths(&shape.y), text]],
    })
}
