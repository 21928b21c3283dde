# Timing constraints of the module @MODULE@. Driving cells, loads, uncertainty and wires are left to
# your library and layout.

# All registers change at the rising edge of the only clock. The period is that of `generate --period`.
create_clock -name clk_i -period @PERIOD@ [get_ports clk_i]

# Inputs come from registers of this clock, and so does the release of the reset.
set raypath_inputs {
@INPUTS@}
# Outputs go to registers of this clock.
set raypath_outputs {
@OUTPUTS@}

# Set-up: the logic outside has @SHARE@ % of the period before an input.
set_input_delay -clock clk_i -max @OUTSIDE@ [get_ports $raypath_inputs]
# Hold: at worst, an input changes at the clock edge.
set_input_delay -clock clk_i -min 0 [get_ports $raypath_inputs]
# Set-up: it has @SHARE@ % of the period after an output.
set_output_delay -clock clk_i -max @OUTSIDE@ [get_ports $raypath_outputs]
# Hold: an output may change at the clock edge.
set_output_delay -clock clk_i -min 0 [get_ports $raypath_outputs]

# The reset is active low and asynchronous: its falling edge may come at any time. Its rising edge
# comes from a reset synchroniser, and recovery and removal are checked.
set_false_path -fall_from [get_ports rst_ni]
