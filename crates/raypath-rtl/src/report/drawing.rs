//! Functions that the pictures share.

use svg::Document;
use svg::node::element::{Line, Rectangle, Style, Text, Title};

const STYLE: &str = "text { font: 12px sans-serif; fill: #222 } .head { font-weight: bold } \
    .small { font-size: 10.5px } \
                     .on { fill: #fff } .right { text-anchor: end } .middle { text-anchor: middle }";

/// An empty picture with a white background.
pub fn picture(title: &str, width: i32, height: i32) -> Document {
    Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .add(Title::new(title))
        .add(Style::new(STYLE))
        .add(rectangle(0, 0, width, height, "#ffffff"))
}

/// A filled rectangle.
pub fn rectangle(x: i32, y: i32, width: i32, height: i32, fill: &str) -> Rectangle {
    Rectangle::new().set("x", x).set("y", y).set("width", width).set("height", height).set("fill", fill)
}

/// A text at a position; `class` is a class of the style sheet.
pub fn text(x: i32, y: i32, class: &str, words: &str) -> Text {
    Text::new(words).set("x", x).set("y", y).set("class", class)
}

/// A thin line.
pub fn line(from: (i32, i32), to: (i32, i32), colour: &str) -> Line {
    Line::new().set("x1", from.0).set("y1", from.1).set("x2", to.0).set("y2", to.1).set("stroke", colour)
}
