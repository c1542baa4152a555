# Data: docs/development/decisions/006-default-scheme.md. Run
# in this folder: gnuplot chosen_steps.gp
set terminal pngcairo size 900,520 font "DejaVu Sans,12"
set output "chosen_steps.png"
set logscale xy
set format x "10^{%L}"
set format y "10^{%L}"
set xlabel "velocity solves to just after the sixth contact onset, including refused steps"
set ylabel "greatest error of the first six contact onsets (s)"
set grid lc rgb "#d0d0d0"
set key top right
set xrange [40:3e4]
set yrange [1e-14:1e-2]
$fixed << EOD
1183 3.0e-6
11824 1.5e-6
EOD
$chosen << EOD
60 2.6e-6
72 2.4e-7
105 2.3e-8
177 2.3e-9
333 2.4e-10
675 2.4e-11
EOD
$auto << EOD
228 6.5e-14
EOD
plot $chosen w lp lw 2 pt 7 lc rgb "#0060ad" t "Moreau–Jean, adaptive steps (tolerance 10^{-4} … 10^{-9})", $fixed w lp lw 2 pt 5 lc rgb "#b03030" t "Moreau–Jean, fixed steps (10^{-5}, 10^{-6} s; only five onsets at 10^{-4})", $auto w p pt 9 ps 2 lc rgb "#208040" t "automatic (here event-driven, 10^{-10})"
