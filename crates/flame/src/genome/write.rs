//! Writing flam3 XML.
//!
//! Owns the attribute names for writing. Nothing is dropped, and numbers read back bit for bit.
//!
//! Start at [`Genome::to_xml`].

use std::fmt::{Display, Write};

use super::carry::Carrier;
use super::{Affine, Element, Genome, Palette, PaletteBlend, Wave, Xform};
use variations::Variation;

impl Genome {
    /// The flame as one `<flame>` element, with every attribute and everything that was kept.
    ///
    /// Reading it back gives an equal genome.
    pub fn to_xml(&self) -> String {
        let mut root = Element { tag: "flame".into(), ..Element::default() };
        if let Some(name) = &self.name {
            root.set("name", name);
        }
        root.set("time", self.time);
        self.write_camera(&mut root);
        self.write_sampling(&mut root);
        self.write_tone(&mut root);
        self.write_finish(&mut root);
        if let Some(number) = self.palette_number {
            root.set("palette", number);
        }
        root.set_unless_0("hue", self.hue);
        root.set("palette_mode", self.palette_mode.name());
        root.set("palette_interpolation", self.hue_path.name());
        root.set("hsv_rgb_palette_blend", self.hue_path_rgb);
        root.set("interpolation", self.interpolation.name());
        root.set("interpolation_type", self.space.name());
        root.attributes.extend(self.extra.iter().cloned());
        let carrier = Carrier::of(self);
        root.children.extend(self.xforms.iter().map(|xform| xform.element("xform", carrier)));
        root.children.extend(self.finals.iter().map(|xform| xform.element("finalxform", carrier)));
        for kind in &self.symmetries {
            let mut symmetry = Element { tag: "symmetry".into(), ..Element::default() };
            symmetry.set("kind", kind);
            root.children.push(symmetry);
        }
        root.children.extend(self.palette.iter().flat_map(Palette::elements));
        root.children.extend(self.palette_blend.iter().map(PaletteBlend::element));
        root.children.extend(self.children.iter().cloned());
        let mut out = String::new();
        root.write(&mut out, 0);
        out
    }

    fn write_camera(&self, root: &mut Element) {
        root.set_all("size", self.camera.size);
        root.set_all("center", self.camera.center);
        root.set("scale", self.camera.scale);
        root.set("zoom", self.camera.zoom);
        root.set("rotate", self.camera.rotate);
        self.write_unusual_camera(root);
        self.camera.pose.write(root);
    }

    fn write_sampling(&self, root: &mut Element) {
        let sampling = &self.sampling;
        root.set("supersample", sampling.supersample);
        root.set("filter", sampling.filter_radius);
        root.set("filter_shape", sampling.filter_shape.name());
        root.set("temporal_filter_type", sampling.temporal_shape.name());
        root.set("temporal_filter_width", sampling.temporal_width);
        root.set("temporal_filter_exp", sampling.temporal_exponent);
        root.set("quality", sampling.quality);
        root.set("passes", sampling.passes);
        root.set("temporal_samples", sampling.temporal_samples);
        root.set("estimator_radius", sampling.estimator_radius);
        root.set("estimator_minimum", sampling.estimator_minimum);
        root.set("estimator_curve", sampling.estimator_curve);
    }

    fn write_tone(&self, root: &mut Element) {
        root.set_all("background", self.tone.background);
        root.set("brightness", self.tone.brightness);
        root.set("gamma", self.tone.gamma);
        root.set("gamma_threshold", self.tone.gamma_threshold);
        root.set("vibrancy", self.tone.vibrancy);
        root.set("highlight_power", self.tone.highlight_power);
    }
}

impl Xform {
    fn element(&self, tag: &str, carrier: Carrier) -> Element {
        let mut element = Element { tag: tag.into(), ..Element::default() };
        element.children.extend(self.motions.iter().map(Wave::element));
        element.children.extend(self.children.iter().cloned());
        if tag == "xform" || self.weight != 0.0 {
            element.set("weight", self.weight);
        }
        element.set_all("color", std::iter::once(self.color).chain(self.color2));
        element.set("color_speed", self.color_speed);
        element.set("animate", self.animate);
        element.set("opacity", self.opacity);
        if !self.chaos.is_empty() {
            element.set_all("chaos", self.chaos.iter());
        }
        element.set_all("coefs", self.affine.columns());
        if self.post != Affine::IDENTITY {
            element.set_all("post", self.post.columns());
        }
        self.tilt.write("Coefs", &mut element);
        self.post_tilt.write("Post", &mut element);
        for variation in &Variation::spelled(&[&self.variations[..], &self.left_out].concat()) {
            element.set(&variation.attribute(), variation.weight);
            for (parameter, value) in variation.kind.parameters().iter().zip(variation.params) {
                element.set(&variation.parameter_attribute(parameter.name), value);
            }
            for (name, value) in variation.stage_attributes() {
                element.set(&name, value);
            }
            if variation.carry != carrier.usual(variation.kind) {
                element.set(&variation.carry_attribute(), variation.carry);
            }
        }
        element.attributes.extend(self.extra.iter().cloned());
        element
    }
}

impl Palette {
    /// Hexadecimal where all colours are bytes, else one element per colour.
    fn elements(&self) -> Vec<Element> {
        let bytes = self.entries.as_flattened();
        if bytes.iter().all(|value| value.fract() == 0.0 && (0.0..=255.0).contains(value)) {
            let opaque = self.entries.iter().all(|entry| entry[3] == 255.0);
            let (format, channels) = if opaque { ("RGB", 3) } else { ("RGBA", 4) };
            let mut palette = Element { tag: "palette".into(), ..Element::default() };
            palette.set("count", Palette::LEN);
            palette.set("format", format);
            for row in self.entries.chunks(8) {
                palette.text.push('\n');
                for value in row.iter().flat_map(|entry| &entry[..channels]) {
                    let _ = write!(palette.text, "{:02X}", *value as u8);
                }
            }
            palette.text.push('\n');
            return vec![palette];
        }
        let single = |(index, entry): (usize, &[f64; 4])| {
            let mut color = Element { tag: "color".into(), ..Element::default() };
            color.set("index", index);
            if entry[3] == 255.0 {
                color.set_all("rgb", &entry[..3]);
            } else {
                color.set_all("rgba", entry);
            }
            color
        };
        self.entries.iter().enumerate().map(single).collect()
    }
}

impl Element {
    /// Adds an attribute unless its value is 0.
    pub(super) fn set_unless_0(&mut self, name: &str, value: f64) {
        if value != 0.0 {
            self.set(name, value);
        }
    }

    pub(super) fn set(&mut self, name: &str, value: impl Display) {
        self.attributes.push((name.into(), value.to_string()));
    }

    pub(super) fn set_all(&mut self, name: &str, values: impl IntoIterator<Item = impl Display>) {
        let words: Vec<String> = values.into_iter().map(|value| value.to_string()).collect();
        self.attributes.push((name.into(), words.join(" ")));
    }

    fn write(&self, out: &mut String, depth: usize) {
        let indent = "   ".repeat(depth);
        let _ = write!(out, "{indent}<{}", self.tag);
        for (name, value) in &self.attributes {
            let _ = write!(out, " {name}=\"{}\"", escaped(value));
        }
        if self.children.is_empty() && self.text.is_empty() {
            out.push_str("/>\n");
            return;
        }
        out.push('>');
        out.push_str(&escaped_text(&self.text));
        if !self.children.is_empty() {
            out.push('\n');
            for child in &self.children {
                child.write(out, depth + 1);
            }
            out.push_str(&indent);
        }
        let _ = writeln!(out, "</{}>", self.tag);
    }
}

fn escaped_text(text: &str) -> String {
    // A return that is not escaped reads back as a new line.
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('\r', "&#13;")
}

fn escaped(value: &str) -> String {
    escaped_text(value).replace('"', "&quot;").replace('\n', "&#10;").replace('\t', "&#9;")
}
