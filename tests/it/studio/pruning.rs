//! What cannot be reached, as the studio answers.
//!
//! Owns the claim that it proposes what `dreams prune` proposes. How the page drops it is in `slow/studio/pruning.rs`.

use claims::studio::running::Studio;
use claims::studio::unreachable::{flock, prune};
use serde_json::{Value, json};

#[test]
fn the_page_proposes_what_the_command_proposes_and_says_what_would_bring_the_rest_in() {
    let flock = flock();
    let studio = Studio::of(flock.path());
    let (told, proposed) = (studio.get("/api/prune"), prune(flock.path(), &[]));
    assert_eq!((&told["drop"], &told["ties"], &told["fewest"]), (&proposed["drop"], &proposed["ties"], &json!(1)));
    assert_eq!(told["was"]["worst_ratio"], studio.get("/api/state")["figures"]["worst_ratio"]);
    assert_eq!((&told["figures"]["sheep"], &told["figures"]["shown"]), (&json!(6), &json!(6)));
    let link = |of: &Value| json!({ "from": of["from"], "to": of["to"], "frames": of["frames"] });
    let links = |parts: &Value, of: fn(&Value) -> Vec<&Value>| -> Vec<Value> {
        parts.as_array().unwrap().iter().flat_map(of).filter(|one| !one.is_null()).map(link).collect()
    };
    let ours = links(&told["parts"], |part| part["links"].as_array().unwrap().iter().collect());
    assert_eq!(ours, links(&proposed["parts"], |part| vec![&part["entry"], &part["exit"]]));
    assert_eq!(studio.ask("GET", "/api/prune?keep=x0", None).status, 409, "no cycle leads through it");
    assert_eq!(studio.ask("GET", "/api/prune?keep=nobody", None).status, 404);
}
