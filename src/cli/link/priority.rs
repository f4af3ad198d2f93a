/// Above usual threads, below the kernel's threads at 99.
#[cfg(target_os = "linux")]
const PRIORITY: u8 = 80;

/// Asks for real-time priority, if wanted. Describes the granted priority.
#[cfg(target_os = "linux")]
pub(super) fn ask(is_wanted: bool) -> String {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy,
        thread_native_id,
    };
    if !is_wanted {
        return "usual priority".into();
    }
    let asked = ThreadPriority::Crossplatform(PRIORITY.try_into().unwrap_or_default());
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    match set_thread_priority_and_policy(thread_native_id(), asked, policy) {
        Ok(()) => format!("SCHED_FIFO with priority {PRIORITY}"),
        Err(error) => {
            format!("usual priority: real time was refused ({error:?}); it needs CAP_SYS_NICE or a limit of ulimit -r")
        }
    }
}

#[cfg(not(target_os = "linux"))]
pub(super) fn ask(is_wanted: bool) -> String {
    let given = "usual priority";
    if is_wanted { format!("{given}: real time is asked for on Linux only") } else { given.into() }
}
