//! What reading and writing genomes keeps, and what reading refuses.
//!
//! Owns claims about flam3 XML; what a genome looks like is for `flam3.rs` and `pictures.rs`.

#![allow(clippy::float_cmp, reason = "values are read, not computed")]

use crate::bred;
use flame::genome::Affine;
use flame::genome::{HuePath, PaletteMode};
use flame::{Genome, GenomeError};
use proptest::prelude::{any, prop_assert_eq, proptest};

proptest! {
    #[test]
    fn a_written_genome_reads_back_equal(seed in any::<u64>()) {
        let mut genome = bred::genome(seed);
        // Each of the four affine parts in space, or none.
        let tilted = Affine { a: 0.5, b: 0.1, c: seed as f64, d: -0.3, e: 1.0, f: 0.25 };
        let first = &mut genome.xforms[0];
        let parts = [&mut first.tilt.yz, &mut first.tilt.zx, &mut first.post_tilt.yz, &mut first.post_tilt.zx];
        if let Some(part) = parts.into_iter().nth((seed % 5) as usize) {
            *part = tilted;
        }
        let text = genome.to_xml();
        prop_assert_eq!(Genome::parse(&text).unwrap(), genome);
    }
}

#[test]
fn a_file_may_hold_several_flames_at_any_depth() {
    let text = r#"<pick><a><flame name="one"/></a><flame name="two"/></pick>"#;
    let names: Vec<_> = Genome::parse_all(text).unwrap().into_iter().filter_map(|genome| genome.name).collect();
    assert_eq!(names, ["one", "two"]);
    assert_eq!(Genome::parse(text), Err(GenomeError::Count { found: 2 }));
    assert_eq!(Genome::parse("<none/>"), Err(GenomeError::Count { found: 0 }));
}

#[test]
fn what_is_unknown_is_kept() {
    let text = r#"<flame mood="blue"><xform weight="1" waltz="0.3" waltz_shift="0.1"/><edit nick="us"/></flame>"#;
    let again = Genome::parse(text).unwrap().to_xml();
    for kept in [r#"mood="blue""#, r#"waltz="0.3""#, r#"waltz_shift="0.1""#, r#"<edit nick="us"/>"#] {
        assert!(again.contains(kept), "{kept} is missing in {again}");
    }
}

#[test]
fn a_wrong_value_is_named_with_its_line_and_its_column() {
    let text = "<flames>\n<flame>\n<xform weight=\"1\"\n coefs=\"1 0 0 1 0\"/>\n</flame></flames>";
    assert_eq!(
        Genome::parse_all(text).unwrap_err().to_string(),
        "line 4, column 2: attribute `coefs` of `xform` is `1 0 0 1 0`, expected six numbers"
    );
    for (attribute, value) in [("size", "12"), ("gamma", "inf"), ("quality", "x"), ("supersample", "0")] {
        let refused = Genome::parse(&format!(r#"<flame {attribute}="{value}"/>"#)).unwrap_err().to_string();
        assert!(refused.contains(&format!("`{attribute}` of `flame` is `{value}`")), "{refused}");
    }
    assert!(matches!(Genome::parse("<flame>"), Err(GenomeError::Xml { .. })));
    let short = Genome::parse("<flame><palette format=\"RGB\">00ff</palette></flame>").unwrap_err();
    assert_eq!(
        short.to_string(),
        "line 1, column 8: palette `palette` has 4 digits, expected 256 colours, or as many as its `count`, of 6 or 8 digits"
    );
    let long = Genome::parse(&format!("<flame zoom=\"{}\"/>", "é".repeat(1 << 20))).unwrap_err().to_string();
    assert!(long.len() < 300 && long.starts_with("line 1, column 8: "), "{long}");
}

#[test]
fn values_as_other_programs_write_them_are_read() {
    let text = r#"<flame name="" size="800.0 600.0" supersample="2.0" temporal_samples="1.0" passes="" zoom="" palette="7.0"
        filter_shape="Gaussian" temporal_filter_type="BOX" palette_mode=" Linear" palette_interpolation="hsv2"
        center="nan -1.#IND" soloxform=""><symmetry kind="3.0"/><color index="0.0" rgb="9 9 9"/></flame>"#;
    let genome = Genome::parse(text).unwrap();
    assert_eq!((genome.camera.size, genome.camera.center, genome.camera.zoom), ([800, 600], [0.0; 2], 0.0));
    assert_eq!((genome.sampling.supersample, genome.sampling.temporal_samples, genome.sampling.passes), (2, 1, 1));
    assert_eq!((genome.palette_number, genome.symmetries.as_slice()), (Some(7), [3].as_slice()));
    assert_eq!((genome.palette_mode, genome.hue_path), (PaletteMode::Linear, HuePath::HsvCircular));
    let notes = &Genome::split(text).unwrap()[0].notes;
    assert_eq!(notes, &["its center is `nan -1.#IND`, read as `0 0`"]);
    let endless = "<flame center=\"inf 0\"/>";
    assert_eq!(Genome::parse(endless).unwrap().camera.center, [0.0; 2]);
    assert_eq!(Genome::split(endless).unwrap()[0].notes, ["its center is `inf 0`, read as `0 0`"]);
    for (attribute, value) in [("temporal_samples", "1.5"), ("size", "8.5 6"), ("center", "0"), ("palette", "1.5")] {
        let refused = Genome::parse(&format!(r#"<flame {attribute}="{value}"/>"#)).unwrap_err().to_string();
        assert!(refused.contains(&format!("`{attribute}` of `flame` is `{value}`")), "{refused}");
    }
}

#[test]
fn a_palette_may_have_as_many_colours_as_its_count() {
    let of = |count: &str, colours: usize| {
        let colours: Vec<_> = (0..colours).map(|i| format!("{:02x}0000", i * 255 / (colours - 1))).collect();
        format!("<flame><palette {count} format=\"RGB\">{}</palette></flame>", colours.concat())
    };
    let ramp = Genome::parse(&of("", 256)).unwrap().palette.unwrap();
    for count in [2, 100, 512, 1024] {
        let text = of(&format!("count=\"{count}\""), count);
        let part = Genome::split(&text).unwrap().remove(0);
        assert_eq!(part.notes, [format!("its palette has {count} colours, drawn as 256")]);
        let found = part.genome.unwrap().palette.unwrap();
        let off = found.entries.iter().zip(&ramp.entries).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max);
        assert!(off <= 1.0, "{count}: {off}");
    }
    for (count, colours) in [("count=\"512\"", 256), ("", 512), ("count=\"0\"", 256), ("count=\"x\"", 256)] {
        assert!(matches!(Genome::parse(&of(count, colours)), Err(GenomeError::Palette { .. })), "{count} {colours}");
    }
}

#[test]
fn missing_colours_are_blended_from_their_neighbours() {
    let text = r#"<flame><color index="10" rgb="0 0 0"/><color index="20" rgb="100 50 0"/></flame>"#;
    let entries = Genome::parse(text).unwrap().palette.unwrap().entries;
    assert_eq!(entries[15], [50.0, 25.0, 0.0, 255.0]);
    assert!(entries[255][0] > entries[0][0] && entries[0][0] > 0.0, "the gap reaches around the end");
}

#[test]
fn legacy_attributes_mean_what_they_meant() {
    let text = r#"<flame><xform weight="1" symmetry="1" var="0 0.5" color="0.25 0"/><xform var1="13"/></flame>"#;
    let xforms = Genome::parse(text).unwrap().xforms;
    assert_eq!((xforms[0].color_speed, xforms[0].animate, xforms[0].color), (0.0, 0.0, 0.25));
    assert_eq!((xforms[0].variations[0].kind.name(), xforms[0].variations[0].weight), ("sinusoidal", 0.5));
    assert_eq!((xforms[1].variations[0].kind.name(), xforms[1].variations[0].weight), ("julia", 1.0));
}

#[test]
fn jwildfires_choices_among_ways_of_drawing_are_applied() {
    let read = |attributes: &str| {
        let text = format!("<flame><xform weight=\"1\" color_speed=\"0.5\" elliptic=\"0.7\" {attributes}/></flame>");
        Genome::parse(&text).unwrap()
    };
    let [plain, mirrored, precise] = ["0", "1", "2"].map(|mode| read(&format!("elliptic_mode=\"{mode}\"")));
    assert_eq!((&plain, &precise), (&read(""), &plain));
    assert_eq!(mirrored.xforms[0].variations[0].kind.name(), "elliptic_mirrored");
    assert_eq!(Genome::parse(&mirrored.to_xml()).unwrap(), mirrored);
    assert_eq!(read("elliptic_mode=\"1.5\"").unsupported().refused.0.len(), 1);
    let [kept, coloured] = ["NONE", "DIFFUSION"].map(|kind| read(&format!("color_type=\"{kind}\"")));
    assert_eq!((kept.xforms[0].color_speed, coloured.xforms[0].color_speed), (0.0, 0.5));
    let refused = |base: &str| !read(&format!("log=\"1\" log_base=\"{base}\"")).unsupported().refused.is_empty();
    assert_eq!(["2.7183", "2", "-2"].map(refused), [false, false, true]);
}
