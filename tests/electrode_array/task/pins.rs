//! Tasks of droplets on boards with shared channels, compared with all their plans.

use super::*;

impl Task {
    /// Gives a board of droplets shared channels, which sometimes do not hold resting droplets.
    fn pinned(mut self, chance: &mut Random) -> Task {
        let mut pins = Pins::random(self.size, &[], chance);
        pins.is_held = chance.below(3) > 0;
        for obstacle in &self.obstacles {
            match obstacle {
                Obstacle::Stuck(at) => pins.stuck.push(*at),
                Obstacle::Disabled(at) => pins.dead.push(*at),
                Obstacle::Block(..) | Obstacle::Gap(_) => {}
            }
        }
        self.pins = Some(pins);
        self
    }
}

#[test]
fn tasks_on_shared_channels_agree_with_all_their_plans() {
    let cases = cases(40);
    let mut chance = Random::new(0x7069_6e73);
    let (mut seen, mut done, mut waits, mut merges) = (Seen::default(), 0, 0, 0);
    while done < 2 * cases {
        let Some(task) = Task::random(&mut chance) else { continue };
        if task.kind.can_merge && task.kind.separation <= 3 {
            let mut task = task.pinned(&mut chance);
            task.by_sum = done % 2 == 1;
            if matches!(answered(&task.text()), Answered::Unfit) {
                continue;
            }
            let all = task.all();
            compare(&task, &all, &mut seen);
            for _ in 0..2 {
                task.limits = (0..1 + chance.below(2)).map(|_| limit(&all, &mut chance)).collect();
                compare(&task, &all, &mut seen);
            }
            waits += usize::from(task.waits_ms() > 0);
            merges += usize::from(task.steps.iter().any(|step| step.merge.is_some()));
            done += 1;
        }
    }
    println!("{seen:?}, {waits} with waits, {merges} with merges");
    assert!(seen.proven >= done / 4 && seen.refuted >= done / 2, "{seen:?}");
    assert!(waits > 0 && merges > 0, "{waits} with waits, {merges} with merges");
}
