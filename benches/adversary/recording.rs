//! The forces of recordings over depth.

use super::draw::Draw;

const SHIPPED: &str = include_str!("../../scenarios/recordings/in_vivo_like.csv");

/// About the steepest rise of the shipped recording, in N/m.
const SHIPPED_N_PER_M: f64 = 500.0;

/// Times in s at which the insertion of the shipped recording ends and its withdrawal begins.
const SHIPPED_S: (f64, f64) = (12.0, 14.0);

/// Depths in m, ascending, with the forces in N.
type Curve = Vec<(f64, f64)>;

/// The forces of an insertion and of a withdrawal.
pub struct Recording {
    insertion: Curve,
    withdrawal: Curve,
}

impl Recording {
    /// Layers whose forces rise and fall.
    pub fn draw(draw: &mut Draw, stiffness: f64) -> Self {
        let mut insertion = vec![(0.0, 0.0)];
        let (mut depth_m, mut force_n) = (0.0, 0.0);
        while depth_m < 0.08 {
            let rise_m = draw.log(2e-3, 0.02);
            (depth_m, force_n) = (depth_m + rise_m, force_n + stiffness * rise_m * draw.one(&[1.0, 0.5, 0.2]));
            insertion.push((depth_m, force_n));
            (depth_m, force_n) = (depth_m + draw.log(1e-3, 5e-3), force_n * draw.between(0.1, 1.0));
            insertion.push((depth_m, force_n));
        }
        let out = draw.between(-0.2, 0.9);
        Self { withdrawal: insertion.iter().map(|(depth_m, force_n)| (*depth_m, out * force_n)).collect(), insertion }
    }

    /// The shipped recording, scaled to a steepest rise of about `stiffness`.
    pub fn shipped(stiffness: f64) -> Self {
        let rows = SHIPPED.lines().skip(1).step_by(50).map(|line| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
            (cells[0], (cells[1], cells[3] * stiffness / SHIPPED_N_PER_M))
        });
        let between = |from_s: f64, to_s: f64| {
            rows.clone().filter(move |(time_s, _)| (from_s..to_s).contains(time_s)).map(|(_, point)| point)
        };
        let (insertion, mut withdrawal): (Curve, Curve) =
            (between(0.0, SHIPPED_S.0).collect(), between(SHIPPED_S.1, f64::INFINITY).collect());
        withdrawal.reverse();
        Self { insertion, withdrawal }
    }

    /// Interpolates; outside of the recording the nearest force applies.
    pub fn force_n(&self, depth_m: f64, is_withdrawal: bool) -> f64 {
        let curve = if is_withdrawal { &self.withdrawal } else { &self.insertion };
        let end = curve.partition_point(|(given_m, _)| *given_m < depth_m).clamp(1, curve.len() - 1);
        let ((from_m, from_n), (to_m, to_n)) = (curve[end - 1], curve[end]);
        from_n + (to_n - from_n) * ((depth_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0)
    }
}
