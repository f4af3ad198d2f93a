/// The volume between minimised points and a reference point, by slices along the last objective. The time is
/// exponential in the number of objectives only.
pub fn hypervolume(points: &[&[f64]], reference: &[f64]) -> f64 {
    let inside: Vec<&[f64]> = points
        .iter()
        .copied()
        .filter(|point| point.iter().zip(reference).all(|(value, bound)| value < bound))
        .collect();
    volume(inside, reference)
}

fn volume(mut points: Vec<&[f64]>, reference: &[f64]) -> f64 {
    let Some((&bound, rest)) = reference.split_last() else { return 0.0 };
    if rest.is_empty() {
        return points.iter().map(|point| bound - point[0]).fold(0.0, f64::max);
    }
    let last = rest.len();
    points.sort_by(|a, b| a[last].total_cmp(&b[last]));
    if let [width] = rest {
        // Two objectives form a staircase.
        let (mut area, mut least) = (0.0, *width);
        for point in points {
            if point[0] < least {
                area += (least - point[0]) * (bound - point[1]);
                least = point[0];
            }
        }
        return area;
    }
    let slice = |count: usize| {
        let next = points.get(count).map_or(bound, |point| point[last]);
        let depth = next - points[count - 1][last];
        if depth > 0.0 {
            depth * volume(points[..count].iter().map(|point| &point[..last]).collect(), rest)
        } else {
            0.0
        }
    };
    (1..=points.len()).map(slice).sum()
}
