//! The file: panels and legend drawn by plotters, with a title, and with a style for dark pages.

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::contents::{Chart, ChartPanel, ChartPoint};
use super::palette::{INK, Look, Marker, PAPER, RULE, look, style};
use super::panel::Laid;

/// Width and height of a panel with its axes, in pixels.
const PANEL: (i32, i32) = (256, 208);
/// What lies beside the numbers of a panel: left, top, right, below.
const MARGIN: (i32, i32, i32, i32) = (52, 26, 12, 42);
/// Height of a line of the legend.
const LEGEND: i32 = 22;
/// Width of a letter, about.
const LETTER: i32 = 7;
/// Width of the look of a line in the legend.
const SAMPLE: i32 = 30;
/// Half the size of a marker.
const MARKER: i32 = 3;

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// The chart as an SVG file.
pub fn to_svg(chart: &Chart) -> String {
    let columns = chart.columns.clamp(1, chart.panels.len().max(1));
    let rows = chart.panels.len().div_ceil(columns);
    let width = PANEL.0 * columns as i32;
    let legend = legend(chart, width);
    let above = legend.last().map_or(0, |entry| entry.at.1 + LEGEND);
    let size = (width, above + PANEL.1 * rows as i32);
    let mut text = String::new();
    {
        let canvas = SVGBackend::with_string(&mut text, (size.0 as u32, size.1 as u32)).into_drawing_area();
        // Writing to a string does not fail.
        drop(draw(chart, columns, (&legend, above), &canvas));
    }
    titled(&text, &chart.title)
}

fn draw(chart: &Chart, columns: usize, (legend, above): (&[Entry<'_>], i32), canvas: &Canvas<'_>) -> Drawn {
    canvas.fill(&PAPER.rgb())?;
    for entry in legend {
        let (x, y) = entry.at;
        let middle = y + LEGEND / 2;
        path(canvas, &[(x, middle), (x + SAMPLE, middle)], entry.look)?;
        marker(canvas, (x + SAMPLE / 2, middle), entry.look)?;
        write(canvas, entry.name, (x + SAMPLE + 6, middle), (HPos::Left, VPos::Center), 12)?;
    }
    for (index, panel) in chart.panels.iter().enumerate() {
        let corner = (PANEL.0 * (index % columns) as i32, above + PANEL.1 * (index / columns) as i32);
        frame(panel, corner, canvas)?;
        for line in &panel.lines {
            let look = looks(chart).into_iter().find(|(name, _)| *name == line.name).map(|(_, look)| look);
            if let Some(look) = look {
                curve(&line.places(&panel.axes()), &panel.axes(), corner, (look, canvas))?;
            }
        }
    }
    canvas.present()
}

/// The names of the lines, in the order in which they are met, each with its look.
fn looks(chart: &Chart) -> Vec<(&str, Look)> {
    let mut names: Vec<&str> = Vec::new();
    for line in chart.panels.iter().flat_map(|panel| &panel.lines) {
        if !names.contains(&&*line.name) {
            names.push(&line.name);
        }
    }
    names.into_iter().enumerate().map(|(index, name)| (name, look(index))).collect()
}

/// A line's name and look in the legend.
struct Entry<'a> {
    name: &'a str,
    look: Look,
    at: (i32, i32),
}

/// The legend, in as many rows as it needs.
fn legend(chart: &Chart, width: i32) -> Vec<Entry<'_>> {
    let (mut x, mut y) = (8, 4);
    let entry = |(name, look): (_, Look)| {
        let name: &str = name;
        let wide = SAMPLE + 6 + LETTER * name.chars().count() as i32 + 14;
        if x > 8 && x + wide > width {
            (x, y) = (8, y + LEGEND);
        }
        let at = (x, y);
        x += wide;
        Entry { name, look, at }
    };
    looks(chart).into_iter().map(entry).collect()
}

/// Where a place on the axes lies in the picture.
fn pixel((x, y): (f64, f64), [along, up]: &[Laid; 2], (left, top): (i32, i32)) -> (i32, i32) {
    let share = |place: f64, laid: &Laid| (place - laid.ends.0) / (laid.ends.1 - laid.ends.0);
    let (wide, high) = (PANEL.0 - MARGIN.0 - MARGIN.2, PANEL.1 - MARGIN.1 - MARGIN.3);
    let right = (f64::from(wide) * share(x, along)).round() as i32;
    let down = (f64::from(high) * (1.0 - share(y, up))).round() as i32;
    (left + MARGIN.0 + right, top + MARGIN.1 + down)
}

/// Title, axes and labels of a panel.
fn frame(panel: &ChartPanel, corner: (i32, i32), canvas: &Canvas<'_>) -> Drawn {
    let axes = panel.axes();
    let [along, up] = &axes;
    let at = |x, y| pixel((x, y), &axes, corner);
    let ((left, right), (low, high)) = (along.ends, up.ends);
    for label in &up.labels {
        canvas.draw(&PathElement::new(vec![at(left, *label), at(right, *label)], RULE.rgb()))?;
        let (x, y) = at(left, *label);
        write(canvas, &up.text(*label), (x - 5, y), (HPos::Right, VPos::Center), 11)?;
    }
    let mut free = i32::MIN;
    for label in &along.labels {
        let (x, y) = at(*label, low);
        canvas.draw(&PathElement::new(vec![(x, y), (x, y + 3)], INK.rgb()))?;
        let text = along.text(*label);
        let half = LETTER * text.len() as i32 / 2;
        // Where two labels would touch, the second is left out.
        if x - half >= free {
            write(canvas, &text, (x, y + 5), (HPos::Center, VPos::Top), 11)?;
            free = x + half + 2;
        }
    }
    canvas.draw(&PathElement::new(vec![at(left, high), at(left, low), at(right, low)], INK.rgb()))?;
    let middle = at((left + right) / 2.0, low);
    write(canvas, &panel.x.name, (middle.0, middle.1 + 21), (HPos::Center, VPos::Top), 11)?;
    write(canvas, &panel.title, (corner.0 + MARGIN.0, corner.1 + 6), (HPos::Left, VPos::Top), 12)?;
    let font = ("sans-serif", 11).into_font().transform(FontTransform::Rotate270);
    let ink = INK.rgb();
    let style = TextStyle::from(font).color(&ink).pos(Pos::new(HPos::Center, VPos::Top));
    let middle = at(left, (low + high) / 2.0);
    canvas.draw(&Text::new(panel.y.name.clone(), (corner.0 + 4, middle.1), style))
}

/// A line of a panel, with the intervals of its points.
fn curve(places: &[ChartPoint], axes: &[Laid; 2], corner: (i32, i32), (look, canvas): (Look, &Canvas<'_>)) -> Drawn {
    let points: Vec<(i32, i32)> = places.iter().map(|place| pixel((place.x, place.y), axes, corner)).collect();
    path(canvas, &points, look)?;
    for (place, point) in places.iter().zip(points) {
        if let Some((low, high)) = place.interval {
            let ends = [low, high].map(|end| pixel((place.x, end), axes, corner));
            canvas.draw(&PathElement::new(ends.to_vec(), look.colour.rgb()))?;
        }
        marker(canvas, point, look)?;
    }
    Ok(())
}

/// A line through these points, dashed as its look is.
fn path(canvas: &Canvas<'_>, points: &[(i32, i32)], look: Look) -> Drawn {
    let style = ShapeStyle::from(look.colour.rgb()).stroke_width(2);
    let Some((dash, gap)) = look.dash else {
        return canvas.draw(&PathElement::new(points.to_vec(), style));
    };
    canvas.draw(&DashedPathElement::new(points.iter().copied(), dash, gap, style))
}

fn marker(canvas: &Canvas<'_>, (x, y): (i32, i32), look: Look) -> Drawn {
    let (colour, r) = (look.colour.rgb(), MARKER);
    let filled = ShapeStyle::from(colour).filled();
    match look.marker {
        Marker::Disc => canvas.draw(&Circle::new((x, y), r, filled)),
        Marker::Square => canvas.draw(&Rectangle::new([(x - r, y - r), (x + r, y + r)], filled)),
        Marker::Triangle => {
            canvas.draw(&Polygon::new(vec![(x - r - 1, y + r), (x + r + 1, y + r), (x, y - r - 1)], filled))
        }
        Marker::Cross => {
            canvas.draw(&PathElement::new(vec![(x - r, y - r), (x + r, y + r)], colour))?;
            canvas.draw(&PathElement::new(vec![(x - r, y + r), (x + r, y - r)], colour))
        }
        Marker::Ring => {
            canvas.draw(&Circle::new((x, y), r + 1, ShapeStyle::from(PAPER.rgb()).filled()))?;
            canvas.draw(&Circle::new((x, y), r + 1, ShapeStyle::from(colour).stroke_width(2)))
        }
    }
}

fn write(canvas: &Canvas<'_>, text: &str, at: (i32, i32), (h, v): (HPos, VPos), size: i32) -> Drawn {
    let ink = INK.rgb();
    let style = TextStyle::from(("sans-serif", size)).color(&ink).pos(Pos::new(h, v));
    canvas.draw(&Text::new(text.to_owned(), at, style))
}

/// The file with a title for those who cannot see it, and with its style.
fn titled(svg: &str, title: &str) -> String {
    let escaped = title.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let head = svg.find('>').map_or(0, |end| end + 1);
    let (open, rest) = svg.split_at(head);
    let open = open.replacen("<svg ", "<svg role=\"img\" ", 1);
    format!("{open}\n<title>{escaped}</title>\n{}{}\n", style(), rest.trim_end())
}

#[cfg(test)]
mod tests {
    use super::super::contents::{ChartAxis, Line};
    use super::*;

    fn chart(axis: ChartAxis, ys: &[f64]) -> Chart {
        let point =
            |(x, y): (usize, &f64)| ChartPoint { x: x as f64 + 1.0, y: *y, interval: Some((*y * 0.9, *y * 1.1)) };
        let points: Vec<ChartPoint> = ys.iter().enumerate().map(point).collect();
        let lines = ["a <b>", "c & d"].map(|name| Line { name: name.to_owned(), points: points.clone() });
        let x = ChartAxis::counts("stage", 3);
        let panel = ChartPanel { title: "one \"panel\"".to_owned(), x, y: axis, lines: lines.to_vec() };
        Chart { title: "What <it> & shows".to_owned(), columns: 2, panels: vec![panel.clone(), panel.clone(), panel] }
    }

    /// Any numbers make a well-formed file, the same each time, in which nothing lies outside of the picture.
    #[test]
    fn any_numbers_make_a_sound_picture() {
        let odd = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-300, 1e300];
        for ys in [&[][..], &[0.5], &[0.2, 0.4, 0.9], &odd] {
            for axis in [ChartAxis::shares("share"), ChartAxis::amounts("n"), ChartAxis::log("s", None)] {
                let chart = chart(axis, ys);
                let svg = to_svg(&chart);
                assert_eq!(svg, to_svg(&chart));
                assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{svg}");
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
                assert!(svg.contains("What &lt;it&gt; &amp; shows") && svg.contains("a &lt;b&gt;"), "{svg}");
                let opened = svg.matches("<text").count();
                assert_eq!(opened, svg.matches("</text>").count());
            }
        }
    }

    #[test]
    fn lines_of_one_name_look_alike() {
        let mut chart = chart(ChartAxis::shares("share"), &[0.5, 0.6]);
        chart.panels[1].lines.reverse();
        let names: Vec<&str> = looks(&chart).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["a <b>", "c & d"]);
        let svg = to_svg(&chart);
        // Three panels and the legend.
        let colour = |index| look(index).colour.hex();
        assert!(svg.matches(&colour(0)).count() >= 4 && svg.matches(&colour(1)).count() >= 4, "{svg}");
    }
}
