use trocar::scenario::*; use trocar::metrics::*; use trocar::engine::*;
fn main(){ let args:Vec<String>=std::env::args().collect();
 let s=Scenario::load(&Source::parse(&args[1]), &args[2..]).unwrap_or_else(|e|{println!("{e}");std::process::exit(2)});
 let mut o=(MetricsObserver::<f64>::new(s.grid,4), Trace::new(s.grid)); s.build().unwrap().run(&mut o).unwrap();
 println!("{}", serde_json::to_string_pretty(&o.0.metrics(0)).unwrap());
}
