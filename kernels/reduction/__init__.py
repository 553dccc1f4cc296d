"""The reduction of rolling bodies to one degree of freedom: turning points, periods and paths without time stepping."""
