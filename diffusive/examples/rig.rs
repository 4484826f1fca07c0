use diffusive::identify::rig::{DriftFigures, DriftReport, RoomDrift, campaign};
fn main() {
    let count: u64 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(10);
    let which: Option<usize> = std::env::args().nth(2).and_then(|a| a.parse().ok());
    let mut kinds = Vec::new();
    for (at, room) in RoomDrift::ALL.into_iter().enumerate() {
        if which.is_some_and(|w| w != at) {
            continue;
        }
        let start = std::time::Instant::now();
        let outcomes = campaign(room, count, &|_| {}).unwrap();
        if std::env::var("ALL").is_ok() {
            for o in &outcomes {
                eprintln!("{o:?}");
            }
        }
        eprintln!("{} {:.1} s", room.name(), start.elapsed().as_secs_f64());
        kinds.push(DriftFigures::of(room, &outcomes));
    }
    println!("{}", DriftReport { kinds });
}
