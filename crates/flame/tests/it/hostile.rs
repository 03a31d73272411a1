//! Texts that nobody's program writes: refused before they take time or memory, with place, number and limit.
//!
//! Owns claims about reading what is too large; what is wrong but small is for `xml.rs`, what cannot be drawn for `odd.rs`.

use flame::Genome;

/// `part` of every number below `count`.
fn all(count: usize, part: impl Fn(usize) -> String) -> String {
    (0..count).map(part).fold(String::new(), |all, part| all + &part)
}

/// The refusal of `text`.
fn refusal(text: &str) -> String {
    Genome::parse_all(text).unwrap_err().to_string()
}

#[test]
fn what_holds_too_much_is_refused_with_place_number_and_limit() {
    let flame = |inside: &str| format!("<flame>\n{inside}</flame>");
    for (text, expected) in [
        (
            format!("<flame>\n <xform{}/></flame>", all(120_000, |i| format!(" a{i}='>'"))),
            "line 2, column 3499: 120000 attributes of one element, at most 400 are read",
        ),
        (
            flame(&"<a/>".repeat(2_500_000)),
            "line 2, column 40001: 2500000 elements in one element, at most 10000 are read",
        ),
        ("<a/>".repeat(2_500_000), "line 1, column 40001: 2500000 elements in one element, at most 10000 are read"),
        (
            format!("<f>{}</f>", "<a><flame/><flame/><flame/></a>\n".repeat(4000)),
            "line 3334, column 12: 12000 flames, at most 10000 are read",
        ),
        (
            flame(&"<edit>".repeat(1_000_000)),
            "line 2, column 5995: 1000001 elements nested in each other, at most 1000 are read",
        ),
        (
            flame(&format!("<b>{}</b>\n", "<a/>".repeat(9_999)).repeat(60)),
            "line 51, column 39996: 600001 elements, at most 500000 are read",
        ),
        (
            flame(&format!("<b>{}</b>\n", "<a x=\"\" y='\"' z=''/>".repeat(9_999)).repeat(40)),
            "line 35, column 67332: 1199880 attributes, at most 1000000 are read",
        ),
        (
            flame(&all(17, |i| format!("<a xmlns:n{i}='u{i}'/>"))),
            "line 2, column 304: 17 XML namespaces, at most 16 are read",
        ),
        (flame(&" ".repeat(20 << 20)), "line 2, column 16777209: 20971536 bytes of text, at most 16777216 are read"),
    ] {
        assert_eq!(refusal(&text), expected);
    }
}

#[test]
fn what_looks_like_too_much_and_is_none_of_it_is_read() {
    let tags = "<a b='c'>".repeat(2000);
    let quoted = "<a/>".repeat(20_000).replace('<', "&lt;");
    let text = format!(
        "<?xml version='1.0'?><!-- {tags} --><f><flame name=\"{quoted}\" x='>'><edit>{quoted}</edit>\
         <notes><![CDATA[{tags}]]></notes></flame></f>"
    );
    assert_eq!(Genome::parse(&text).unwrap().name.unwrap(), "<a/>".repeat(20_000));
}

#[test]
fn the_largest_texts_that_may_be_read_are_read() {
    let colours = "   <color index=\"0\" rgb=\"9 9 9\"/>\n".repeat(1000);
    let attributes = all(399, |i| format!(" a{i:03}=\"\""));
    for (text, flames) in [
        (format!("<f>{}</f>", "<flame><color index=\"0\" rgb=\"9 9 9\"/></flame>".repeat(10_000)), 10_000),
        (format!("<f>{}</f>", format!("<flame>{colours}</flame>").repeat(490)), 490),
        (format!("<flame>{}</flame>", format!("<xform{attributes}/>").repeat(2500)), 1),
        (format!("<f>{}</f>", format!("<flame>{}</flame>", "<xform/>".repeat(9_000)).repeat(55)), 55),
    ] {
        assert_eq!(Genome::parse_all(&text).unwrap().len(), flames);
    }
}
