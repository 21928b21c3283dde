module raypath_axi_reader #(
  parameter logic [31:0]            AddressWidth = 32,
  parameter logic [31:0]            DataWidth    = 512,
  parameter logic [31:0]            BurstBytes   = 128,
  parameter logic [31:0]            IdWidth      = 6,
  parameter logic [3:0]             ArCache      = 4'b0011,
  parameter logic [2:0]             ArProt       = 3'b010,
  parameter logic [3:0]             ArQos        = 4'b0000,
  parameter logic [31:0]            ArUserWidth  = 1,
  parameter logic [ArUserWidth-1:0] ArUser       = '0
) (
  // The request of a burst.
  input  logic                    req_valid_i,
  input  logic [AddressWidth-1:0] req_addr_i,
  input  logic [IdWidth-1:0]      req_tag_i,
  output logic                    req_ready_o,
  // A beat of a burst.
  output logic                    rsp_valid_o,
  output logic [IdWidth-1:0]      rsp_tag_o,
  output logic                    rsp_error_o,
  output logic [DataWidth-1:0]    rsp_data_o,
  input  logic                    rsp_ready_i,
  // AXI4, by the names of its specification.
  input  logic                    m_axi_arready,
  output logic                    m_axi_arvalid,
  output logic [IdWidth-1:0]      m_axi_arid,
  output logic [AddressWidth-1:0] m_axi_araddr,
  output logic [7:0]              m_axi_arlen,
  output logic [2:0]              m_axi_arsize,
  output logic [1:0]              m_axi_arburst,
  output logic                    m_axi_arlock,
  output logic [3:0]              m_axi_arcache,
  output logic [2:0]              m_axi_arprot,
  output logic [3:0]              m_axi_arqos,
  output logic [ArUserWidth-1:0]  m_axi_aruser,
  input  logic                    m_axi_rvalid,
  input  logic [IdWidth-1:0]      m_axi_rid,
  input  logic [DataWidth-1:0]    m_axi_rdata,
  input  logic [1:0]              m_axi_rresp,
  input  logic                    m_axi_rlast,
  output logic                    m_axi_rready
);

  localparam logic [31:0] BeatBytes = DataWidth / 8;
  localparam logic [31:0] Beats     = BurstBytes / BeatBytes;

  // Bursts increment. They are aligned to their length, so that none crosses 4 KiB.
  assign m_axi_arlen   = 8'(Beats - 1);
  assign m_axi_arsize  = 3'($clog2(BeatBytes));
  assign m_axi_arburst = 2'b01;
  assign m_axi_arlock  = 1'b0;
  assign m_axi_arcache = ArCache;
  assign m_axi_arprot  = ArProt;
  assign m_axi_arqos   = ArQos;
  assign m_axi_aruser  = ArUser;

  assign m_axi_arvalid = req_valid_i;
  assign m_axi_arid    = req_tag_i;
  assign m_axi_araddr  = req_addr_i;
  assign req_ready_o   = m_axi_arready;

  assign rsp_valid_o   = m_axi_rvalid;
  assign rsp_tag_o     = m_axi_rid;
  assign rsp_error_o   = (m_axi_rresp != 2'b00);
  assign rsp_data_o    = m_axi_rdata;
  assign m_axi_rready  = rsp_ready_i;

  // Readers count the beats of each burst.
  logic unused_rlast;
  assign unused_rlast = m_axi_rlast;

endmodule : raypath_axi_reader
