# docs/decisions/006-default-scheme.md has what was measured. Run here: gnuplot chosen_steps.gp
set terminal pngcairo size 900,520 font "DejaVu Sans,12"
set output "chosen_steps.png"
set logscale xy
set format x "10^{%L}"
set format y "10^{%L}"
set xlabel "velocity solves to just after the sixth touch, refused ones included"
set ylabel "greatest error of the first six touches (s)"
set grid lc rgb "#d0d0d0"
set key top right
set xrange [40:3e4]
set yrange [1e-14:1e-2]
$fixed << EOD
1182 2.6e-5
11821 6.6e-6
EOD
$chosen << EOD
60 8.7e-6
72 8.6e-7
105 8.4e-8
177 8.3e-9
333 8.5e-10
675 8.4e-11
EOD
$auto << EOD
222 8.1e-14
EOD
plot $chosen w lp lw 2 pt 7 lc rgb "#0060ad" t "Moreau–Jean, chosen steps (tolerance 10^{-4} … 10^{-9})", $fixed w lp lw 2 pt 5 lc rgb "#b03030" t "Moreau–Jean, fixed steps (10^{-5}, 10^{-6} s; five touches only at 10^{-4})", $auto w p pt 9 ps 2 lc rgb "#208040" t "automatic (here event-driven, 10^{-10})"
