//! The program is killed while the page is open.
//!
//! Owns the claim that the page ends in the true state: no job that spins for ever, no edit that is shown and was not
//! made.

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::demo;
use serde_json::{Value, json};

/// How often it is killed: `KILLS` for `make soak`, which kills it 50 times.
fn kills() -> u32 {
    std::env::var("KILLS").map_or(5, |kills| kills.parse().expect("KILLS is a number"))
}

/// Whether the page shows what the program says: the jobs, but for strips, which it shows as one.
const SHOWS_JOBS: &str = "(async () => {
  const { secret } = await import('/app/session.js')
  const told = await (await fetch('/api/state', { headers: { 'X-Studio-Secret': secret() } })).json()
  const strips = ['strips', ...told.jobs.filter(job => job.kind === 'strip').map(job => String(job.id))]
  const shown = [...document.querySelectorAll('.view.jobs [data-job]')].filter(row => !strips.includes(row.dataset.job))
  const rows = shown.map(row => `${row.dataset.job} ${row.dataset.state}`).sort()
  const jobs = told.jobs.filter(job => job.kind !== 'strip').map(job => `${job.id} ${job.state}`).sort()
  return document.querySelector('#offline').hidden && rows.join() === jobs.join()
})()";

/// The same of a sheep that is chosen in the graph: how often it is wanted, its share, and what can be undone.
const SHOWS_WANT: &str = "(async () => {
  const { secret } = await import('/app/session.js')
  const told = await (await fetch('/api/state', { headers: { 'X-Studio-Secret': secret() } })).json()
  const aurora = told.sheep.find(one => one.id === 'aurora')
  const shown = document.querySelector('.view.graph input[aria-label=\"Want of aurora, typed\"]')?.value
  const undo = document.querySelector('#tools button')?.title
  return document.querySelector('#offline').hidden && Number(shown) === aurora.want && undo === `Undo: ${told.undo}`
})()";

#[test]
fn killed_in_the_midst_of_jobs_the_program_goes_on_and_the_page_tells_the_truth() {
    let flock = demo();
    let mut studio = Studio::of(flock.path());
    let browser = Browser::start();
    let page = Page::open(&browser, &studio.address(), DESK);
    for kill in 0..kills() {
        page.ask("location.hash = '#/jobs'");
        page.until("the page shows the jobs", "document.body.dataset.view === 'jobs'");
        let state = studio.get("/api/state");
        let pair = &state["transitions"][kill as usize % 20];
        let previews = json!({ "from": pair["from"], "to": pair["to"], "kind": "middles" });
        studio.post("/api/previews", &previews);
        let want = json!([{ "do": "want", "sheep": "aurora", "value": f64::from(kill) + 2.0 }]);
        studio.edit(&state["revision"], &want);
        studio.kill_and_restart();
        // The artist opens the address that is printed now, in the same tab.
        page.ask(&format!("location.href = '{}'", studio.address()));
        page.until(
            "the page is signed in again",
            "document.querySelector('#offline').hidden && document.querySelector('#closed').hidden",
        );
        page.ask("location.hash = '#/jobs'");
        page.until(&format!("after kill {kill} the page shows the jobs that there are"), SHOWS_JOBS);
        page.ask("location.hash = '#/graph?at=aurora'");
        page.until(&format!("after kill {kill} the page shows the want that was set"), SHOWS_WANT);
        let state = studio.get("/api/state");
        let aurora = state["sheep"].as_array().unwrap().iter().find(|sheep| sheep["id"] == "aurora").unwrap();
        assert_eq!(aurora["want"], f64::from(kill) + 2.0, "an edit that was answered is there");
    }
    // Every job comes to an end, and none is left that neither waits nor runs.
    let over = ["done", "failed", "cancelled"].map(Value::from);
    claims::wait::until("all jobs are over", 300, || {
        studio.get("/api/jobs")["jobs"].as_array().unwrap().iter().all(|job| over.contains(&job["state"]))
    });
    page.ask("location.hash = '#/jobs'");
    page.until("the page shows that all is over", SHOWS_JOBS);
}
